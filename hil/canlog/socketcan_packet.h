// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string_view>

#include "hil/canlog/log_frame.h"

namespace pipewright::hil {

inline constexpr std::uint32_t kLinkTypeSocketCan = 227;
inline constexpr std::size_t kSocketCanMostBytes = 72;

/// Numbers of a capture, whose byte order its head tells.
class CaptureNumbers {
 public:
  explicit CaptureNumbers(bool big_endian = false) : big_endian_(big_endian) {}

  std::uint16_t U16(const char* from) const { return static_cast<std::uint16_t>(Take<2>(from)); }
  std::uint32_t U32(const char* from) const { return static_cast<std::uint32_t>(Take<4>(from)); }
  std::uint64_t U64(const char* from) const { return Take<8>(from); }

 private:
  template <int kBytes>
  std::uint64_t Take(const char* from) const {
    std::uint64_t value = 0;
    for (int i = 0; i < kBytes; ++i) {
      value = value << 8 | static_cast<unsigned char>(from[big_endian_ ? i : kBytes - 1 - i]);
    }
    return value;
  }

  bool big_endian_;
};

/// A packet of link type 227 (tcpdump.org's LINKTYPE_CAN_SOCKETCAN): id and flags with the high
/// byte first, length, CAN FD flags, two bytes of no use, payload, padding. Old captures of CAN FD
/// do not flag it: there, a packet of 72 bytes or a payload of more than 8 tells.
///
/// All of `frame` is set but stamp, channel and direction.
/// @returns what was expected, or null
const char* ReadSocketCanPacket(std::string_view packet, LogFrame& frame);

}  // namespace pipewright::hil
