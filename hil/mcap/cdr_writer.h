// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "hil/mcap/little_endian.h"

namespace pipewright::hil {

/// The bytes of a ROS 2 message: plain CDR, little-endian (OMG DDS-XTYPES 1.3, 7.4.1; version 1).
///
///   00 01 00 00          the encapsulation: CDR_LE, no options
///   fields               each aligned to its size, counted from behind the encapsulation
///   string               uint32 length with its end, the characters, 00
///   sequence             uint32 length, then its elements
class CdrWriter {
 public:
  /// Begins anew; what was allocated is kept.
  void Begin() { bytes_.assign("\0\1\0\0", kHeadBytes); }

  template <typename Number>
  void Put(Number value) {
    while ((bytes_.size() - kHeadBytes) % sizeof value != 0) {
      bytes_ += '\0';
    }
    AppendNumber(bytes_, value);
  }
  void Put(std::string_view text) {
    Put(static_cast<std::uint32_t>(text.size() + 1));
    bytes_.append(text);
    bytes_ += '\0';
  }
  /// A sequence of bytes.
  void PutBytes(std::string_view bytes) {
    PutLength(bytes.size());
    bytes_.append(bytes);
  }
  /// The length of a sequence, whose elements come next.
  void PutLength(std::size_t elements) { Put(static_cast<std::uint32_t>(elements)); }

  std::string_view bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kHeadBytes = 4;

  std::string bytes_;
};

}  // namespace pipewright::hil
