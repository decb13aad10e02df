// SPDX-License-Identifier: MIT
#include "hil/canlog/pcap_packets.h"

#include <fmt/format.h>

#include "hil/canlog/line_scanner.h"

namespace pipewright::hil {
namespace {

constexpr std::size_t kHeadBytes = 24;
constexpr std::size_t kPacketHeadBytes = 16;
constexpr std::uint32_t kMicroseconds = 0xA1B2C3D4;
constexpr std::uint32_t kNanoseconds = 0xA1B23C4D;
constexpr std::uint32_t kLinkTypeMask = 0x0FFFFFFF;  // above: the length of a checksum
constexpr std::int64_t kNsPerSecond = 1'000'000'000;

bool IsMagic(std::uint32_t value) { return value == kMicroseconds || value == kNanoseconds; }

}  // namespace

bool PcapPackets::Begins(std::string_view begin) {
  return begin.size() >= 4 && (IsMagic(CaptureNumbers(false).U32(begin.data())) ||
                               IsMagic(CaptureNumbers(true).U32(begin.data())));
}

bool PcapPackets::TakeHead(LogInput& in) {
  const std::string_view head = in.bytes.Peek(kHeadBytes);
  if (head.size() < kHeadBytes) {
    in.problems.EndsEarly(fmt::format("ends within its head, at byte {}", head.size()));
    return false;
  }
  numbers_ = CaptureNumbers(!IsMagic(CaptureNumbers(false).U32(head.data())));
  ns_per_unit_ = numbers_.U32(head.data()) == kNanoseconds ? 1 : 1000;
  const std::uint32_t link_type = numbers_.U32(head.data() + 20) & kLinkTypeMask;
  if (link_type != kLinkTypeSocketCan) {
    in.problems.EndsEarly(
        fmt::format("byte 20: is a capture of link type {}; expected {}, SocketCAN", link_type,
                    kLinkTypeSocketCan));
    return false;
  }
  in.bytes.Skip(kHeadBytes);
  channel_ = in.channels.Number("can");  // pcap does not name it
  return true;
}

bool PcapPackets::TakePacket(LogInput& in, LogFrame& frame, bool& is_frame) {
  const std::uint64_t at = in.bytes.position();
  const std::string_view head = in.bytes.Peek(kPacketHeadBytes);
  if (head.empty()) {
    return false;
  }
  const auto ends = [&in, at] {
    in.problems.EndsEarly(fmt::format("ends within the packet that begins at byte {}", at));
    return false;
  };
  if (head.size() < kPacketHeadBytes) {
    return ends();
  }
  const std::int64_t seconds = numbers_.U32(head.data());
  const std::int64_t fraction = numbers_.U32(head.data() + 4);
  const std::uint32_t bytes = numbers_.U32(head.data() + 8);
  if (bytes > kMostPacketBytes) {
    in.problems.EndsEarly(fmt::format(
        "byte {}: a packet of {} bytes; expected at most {}, so what follows is not read", at,
        bytes, kMostPacketBytes));
    return false;
  }
  in.bytes.Skip(kPacketHeadBytes);
  // Anything longer than the longest frame is malformed, whatever it is.
  const std::string_view packet = in.bytes.Peek(std::min<std::size_t>(bytes, kSocketCanMostBytes));
  Clear(frame);
  frame.stamp_ns = seconds * kNsPerSecond + fraction * ns_per_unit_;
  frame.stamped = true;
  frame.channel = channel_;
  const char* const expected = ReadSocketCanPacket(packet, frame);
  if (in.bytes.Skip(bytes) < bytes) {
    return ends();
  }
  is_frame = expected == nullptr;
  if (!is_frame) {
    in.problems.Malformed(fmt::format("byte {}", at), expected, "");
  }
  return true;
}

std::size_t PcapPackets::Fill(LogInput& in, std::span<LogFrame> out) {
  if (!open_) {
    open_ = true;
    ended_ = !TakeHead(in);
  }
  std::size_t frames = 0;
  while (frames < out.size() && !ended_) {
    bool is_frame = false;
    ended_ = !TakePacket(in, out[frames], is_frame);
    frames += is_frame ? 1 : 0;
  }
  return frames;
}

}  // namespace pipewright::hil
