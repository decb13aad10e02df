// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hil/devices/object_dictionary.h"
#include "platform/core/time.h"

namespace pipewright::hil {

/// What both kinds of PDO share: the communication record and the mapping record of the dictionary.
///
///   communication :1 COB-ID (bit 31: off)  :2 type (0-240 sync, 254/255 event)
///                 :3 inhibit time [100 us]  :5 event timer [ms]
///   mapping       :0 count  :1..8 index << 16 | sub << 8 | bits
class Pdo {
 public:
  Pdo(std::uint16_t communication, std::uint16_t mapping, bool transmit)
      : communication_(communication), mapping_(mapping), transmit_(transmit) {}

  /// Adds both records. COB-ID as given (bit 31 included).
  void AddTo(ObjectDictionary& dictionary, std::uint32_t cob_id, std::uint8_t type,
             const std::vector<std::uint32_t>& entries, std::uint16_t inhibit,
             std::uint16_t timer_ms) const;

  bool Owns(std::uint16_t index) const { return index == communication_ || index == mapping_; }

  /// The rules of CiA 301 7.5.2.35: an identifier changes only through off, mapping only while off
  /// and count 0, entries must exist, be mappable in this direction and together fit 8 bytes.
  AbortCode CheckWrite(const ObjectDictionary& dictionary, std::uint16_t index, std::uint8_t sub,
                       std::uint32_t value) const;

  /// Takes over what the dictionary now says.
  void Configure(ObjectDictionary& dictionary);

  bool enabled() const { return enabled_; }
  std::uint32_t cob_id() const { return cob_id_; }
  bool synchronous() const { return type_ <= 240; }
  int type() const { return type_; }
  int bytes() const { return bytes_; }
  Duration inhibit() const { return inhibit_; }
  Duration timer() const { return timer_; }

  /// The mapped objects' values, first entry lowest.
  std::uint64_t Pack() const;
  /// Writes a payload to the mapped objects.
  void Unpack(std::uint64_t payload) const;

  const std::vector<std::uint32_t>& entries() const { return entries_; }

 private:
  AbortCode CheckMapping(const ObjectDictionary& dictionary, std::uint8_t sub,
                         std::uint32_t value) const;

  std::uint16_t communication_;
  std::uint16_t mapping_;
  bool transmit_;
  bool enabled_ = false;
  std::uint32_t cob_id_ = 0;
  int type_ = 255;
  int bytes_ = 0;
  Duration inhibit_{};
  Duration timer_{};
  std::vector<std::uint32_t> entries_;
  std::vector<Object*> objects_;
};

/// A receive PDO and the payload waiting for the next SYNC.
struct ReceivePdo {
  Pdo pdo;
  std::optional<std::uint64_t> pending;
  std::optional<Time> applied;  ///< when the last one took effect; its deadline counts from here
};

/// A transmit PDO and what was last sent.
struct TransmitPdo {
  Pdo pdo;
  std::uint64_t last_payload = 0;
  bool sent = false;
  Time last_sent{};
  int syncs = 0;
};

}  // namespace pipewright::hil
