// SPDX-License-Identifier: MIT
#include "hil/canlog/socketcan_packet.h"

#include "hil/canlog/line_scanner.h"

namespace pipewright::hil {
namespace {

constexpr std::size_t kHeadBytes = 8;
constexpr std::uint32_t kExtendedFlag = 0x80000000;
constexpr std::uint32_t kRemoteFlag = 0x40000000;
constexpr std::uint32_t kErrorFlag = 0x20000000;
constexpr std::uint32_t kIdMask = 0x1FFFFFFF;
constexpr std::uint32_t kMost11Bits = 0x7FF;
constexpr unsigned kBitrateSwitch = 1;
constexpr unsigned kErrorPassive = 2;
constexpr unsigned kFd = 4;
constexpr unsigned kXl = 0x80;
constexpr int kClassicBytes = 8;

}  // namespace

const char* ReadSocketCanPacket(std::string_view packet, LogFrame& frame) {
  if (packet.size() < kHeadBytes) {
    return "a SocketCAN packet of at least 8 bytes";
  }
  const std::uint32_t id = CaptureNumbers(/*big_endian=*/true).U32(packet.data());
  const unsigned length = static_cast<unsigned char>(packet[4]);
  const unsigned flags = static_cast<unsigned char>(packet[5]);
  if ((length & kXl) != 0) {
    return "classic CAN or CAN FD, not CAN XL";
  }
  const bool fd =
      (flags & kFd) != 0 || length > kClassicBytes || packet.size() == kSocketCanMostBytes;
  frame.id = id & kIdMask;
  frame.error = (id & kErrorFlag) != 0;
  frame.extended = !frame.error && (id & kExtendedFlag) != 0;
  frame.remote = !fd && !frame.error && (id & kRemoteFlag) != 0;
  frame.fd = fd;
  frame.bitrate_switch = fd && (flags & kBitrateSwitch) != 0;
  frame.error_passive = fd && (flags & kErrorPassive) != 0;
  frame.length = static_cast<std::uint8_t>(length);
  if (!frame.extended && !frame.error && frame.id > kMost11Bits) {
    return "an id of 11 bits, or the flag of 29";
  }
  if (!IsFdLength(static_cast<int>(length))) {
    return "a length that CAN or CAN FD has";
  }
  const std::size_t payload = static_cast<std::size_t>(frame.payload_bytes());
  if (packet.size() - kHeadBytes < payload) {
    return "as many payload bytes as the packet's length says";
  }
  std::copy_n(packet.data() + kHeadBytes, payload, reinterpret_cast<char*>(frame.data.data()));
  return nullptr;
}

}  // namespace pipewright::hil
