// SPDX-License-Identifier: MIT
#include "hil/canlog/pcapng_blocks.h"

#include <fmt/format.h>

#include <cmath>

#include "hil/canlog/line_scanner.h"

namespace pipewright::hil {
namespace {

constexpr std::uint32_t kSection = 0x0A0D0D0A;
constexpr std::uint32_t kByteOrder = 0x1A2B3C4D;
constexpr std::uint32_t kInterface = 1;
constexpr std::uint32_t kObsoletePacket = 2;
constexpr std::uint32_t kSimplePacket = 3;
constexpr std::uint32_t kPacket = 6;

constexpr std::uint32_t kLeastBlockBytes = 12;
constexpr std::uint32_t kMostBlockBytes = 1 << 28;  // a section may hold a key log or comments
constexpr std::size_t kBlockHeadBytes = 8;
constexpr std::size_t kMostContent = 16 * 1024;
constexpr std::size_t kMostInterfaces = 1024;

constexpr std::uint16_t kOptionName = 2;
constexpr std::uint16_t kOptionFlags = 2;
constexpr std::uint16_t kOptionTimeUnit = 9;
constexpr std::uint16_t kOptionTimeOffset = 14;
constexpr std::uint64_t kMostUnits = 1'000'000'000'000;
constexpr std::int64_t kMostOffset_s = 9'000'000'000;
constexpr std::int64_t kNsPerSecond = 1'000'000'000;

std::size_t Padded(std::size_t bytes) { return (bytes + 3) / 4 * 4; }

/// Ticks a second: a power of ten, or of two when the high bit is set; 0: none that can be.
std::uint64_t UnitsPerSecond(unsigned code) {
  const std::uint64_t base = (code & 0x80) != 0 ? 2 : 10;
  std::uint64_t units = 1;
  for (unsigned i = 0; i < (code & 0x7F); ++i) {
    if (units > kMostUnits / base) {
      return 0;
    }
    units *= base;
  }
  return units;
}

std::int64_t Nanoseconds(std::uint64_t time, std::uint64_t units_per_second,
                         std::int64_t offset_s) {
  const std::uint64_t seconds =
      std::min<std::uint64_t>(time / units_per_second, static_cast<std::uint64_t>(kMostOffset_s));
  const double fraction = static_cast<double>(time % units_per_second) /  // below 1e12: exact
                          static_cast<double>(units_per_second);
  const std::int64_t sum =
      std::clamp(static_cast<std::int64_t>(seconds) + offset_s, std::int64_t{0}, kMostOffset_s);
  return sum * kNsPerSecond + std::llround(fraction * static_cast<double>(kNsPerSecond));
}

}  // namespace

bool PcapngBlocks::Begins(std::string_view begin) {
  return begin.size() >= 4 && CaptureNumbers().U32(begin.data()) == kSection;
}

template <typename Use>
void PcapngBlocks::ForEachOption(std::string_view content, std::size_t at, Use&& use) const {
  while (at + 4 <= content.size()) {
    const std::uint16_t code = numbers_.U16(content.data() + at);
    const std::size_t bytes = numbers_.U16(content.data() + at + 2);
    if (code == 0 || bytes > content.size() - at - 4) {
      return;
    }
    use(code, content.substr(at + 4, bytes));
    at += 4 + Padded(bytes);
  }
}

bool PcapngBlocks::Damaged(LogInput& in, const Block& block, const char* expected) {
  in.problems.EndsEarly(
      fmt::format("byte {}: expected {}; what follows is not read", block.at, expected));
  return false;
}

/// False: there is no further block, or it makes no sense.
bool PcapngBlocks::Head(LogInput& in, Block& block) {
  block.at = in.bytes.position();
  const std::string_view begin = in.bytes.Peek(kMostContent + kBlockHeadBytes);
  if (begin.empty()) {
    return false;
  }
  if (begin.size() < kLeastBlockBytes) {
    in.problems.EndsEarly(fmt::format("ends within the block that begins at byte {}", block.at));
    return false;
  }
  block.type = numbers_.U32(begin.data());
  if (block.type == kSection) {
    numbers_ = CaptureNumbers(CaptureNumbers(true).U32(begin.data() + 8) == kByteOrder);
    interfaces_.clear();
    if (numbers_.U32(begin.data() + 8) != kByteOrder) {
      return Damaged(in, block, "a section's byte order 1A2B3C4D");
    }
  }
  block.bytes = numbers_.U32(begin.data() + 4);
  if (block.bytes < kLeastBlockBytes || block.bytes % 4 != 0 || block.bytes > kMostBlockBytes) {
    return Damaged(in, block, "a block's length: 12 to 2^28, divisible by 4");
  }
  block.cut = begin.size() < std::min<std::size_t>(block.bytes, kMostContent + kBlockHeadBytes);
  block.content = begin.substr(kBlockHeadBytes, block.bytes - kLeastBlockBytes);
  return true;
}

const char* PcapngBlocks::TakeInterface(LogInput& in, const Block& block) {
  if (block.content.size() < 8) {
    return "an interface of at least 8 bytes";
  }
  if (interfaces_.size() == kMostInterfaces) {
    return "at most 1024 interfaces in a section";
  }
  Interface interface;
  const int link_type = numbers_.U16(block.content.data());
  interface.can = link_type == static_cast<int>(kLinkTypeSocketCan);
  any_can_ = any_can_ || interface.can;
  other_link_type_ = interface.can || other_link_type_ >= 0 ? other_link_type_ : link_type;
  std::string name = fmt::format("can{}", interfaces_.size());
  ForEachOption(block.content, 8, [&](std::uint16_t code, std::string_view value) {
    if (code == kOptionName && !value.empty()) {
      name = value;
    } else if (code == kOptionTimeUnit && value.size() == 1) {
      interface.units_per_second = UnitsPerSecond(static_cast<unsigned char>(value[0]));
    } else if (code == kOptionTimeOffset && value.size() == 8) {
      const auto offset = static_cast<std::int64_t>(numbers_.U64(value.data()));
      interface.offset_s = std::clamp(offset, -kMostOffset_s, kMostOffset_s);
    }
  });
  interface.channel = interface.can ? in.channels.Number(name) : std::uint8_t{0};
  const bool timed = interface.units_per_second > 0;
  interface.units_per_second = timed ? interface.units_per_second : 1;
  interfaces_.push_back(interface);
  return timed ? nullptr : "a unit of time from 1 s to 1e-12 s";
}

bool PcapngBlocks::FindPacket(const Block& block, Packet& packet) const {
  const char* const from = block.content.data();
  if (block.type == kSimplePacket) {
    if (block.content.size() < 4) {
      return false;
    }
    packet = {0, 0, 4, numbers_.U32(from), false};
    packet.bytes =
        std::min(packet.bytes, static_cast<std::uint32_t>(block.content.size() - packet.begin));
    return true;
  }
  if (block.content.size() < 20) {
    return false;
  }
  packet.interface = block.type == kObsoletePacket ? numbers_.U16(from) : numbers_.U32(from);
  packet.time = std::uint64_t{numbers_.U32(from + 4)} << 32 | numbers_.U32(from + 8);
  packet.bytes = numbers_.U32(from + 12);
  packet.begin = 20;
  return true;
}

LogDirection PcapngBlocks::DirectionOf(const Block& block, std::size_t options) const {
  LogDirection direction = LogDirection::kUnknown;
  ForEachOption(block.content, options, [&](std::uint16_t code, std::string_view value) {
    if (code == kOptionFlags && value.size() == 4) {
      const std::uint32_t way = numbers_.U32(value.data()) & 3;
      direction = way == 1   ? LogDirection::kReceived
                  : way == 2 ? LogDirection::kSent
                             : LogDirection::kUnknown;
    }
  });
  return direction;
}

const char* PcapngBlocks::TakePacket(const Block& block, LogFrame& frame, bool& is_frame) {
  Packet packet;
  if (!FindPacket(block, packet)) {
    return "a packet block of at least 32 bytes";
  }
  if (packet.interface >= interfaces_.size()) {
    return "a packet of an interface that was described before";
  }
  const Interface& interface = interfaces_[packet.interface];
  if (!interface.can) {
    return nullptr;
  }
  if (packet.bytes > block.content.size() - packet.begin) {
    return "a packet that fits into its block";
  }
  Clear(frame);
  frame.channel = interface.channel;
  frame.stamped = packet.timed;
  if (packet.timed) {
    frame.stamp_ns = Nanoseconds(packet.time, interface.units_per_second, interface.offset_s);
    frame.direction = DirectionOf(block, packet.begin + Padded(packet.bytes));
  }
  const char* const expected = ReadSocketCanPacket(
      block.content.substr(packet.begin, std::min<std::size_t>(packet.bytes, kSocketCanMostBytes)),
      frame);
  is_frame = expected == nullptr;
  return expected;
}

bool PcapngBlocks::TakeBlock(LogInput& in, LogFrame& frame, bool& is_frame) {
  Block block;
  if (!Head(in, block)) {
    return false;
  }
  const char* expected = nullptr;
  if (block.cut) {
    // said below
  } else if (block.type == kInterface) {
    expected = TakeInterface(in, block);
  } else if (block.type == kPacket || block.type == kObsoletePacket ||
             block.type == kSimplePacket) {
    expected = TakePacket(block, frame, is_frame);
  }
  if (in.bytes.Skip(block.bytes) < block.bytes) {
    is_frame = false;
    in.problems.EndsEarly(fmt::format("ends within the block that begins at byte {}", block.at));
    return false;
  }
  if (expected != nullptr) {
    in.problems.Malformed(fmt::format("byte {}", block.at), expected, "");
  }
  return true;
}

std::size_t PcapngBlocks::Fill(LogInput& in, std::span<LogFrame> out) {
  std::size_t frames = 0;
  while (frames < out.size() && !ended_) {
    bool is_frame = false;
    ended_ = !TakeBlock(in, out[frames], is_frame);
    frames += is_frame ? 1 : 0;
    if (ended_ && !any_can_ && other_link_type_ >= 0) {
      in.problems.EndsEarly(
          fmt::format("holds link type {}; expected an interface of {}, SocketCAN",
                      other_link_type_, kLinkTypeSocketCan));
    }
  }
  return frames;
}

}  // namespace pipewright::hil
