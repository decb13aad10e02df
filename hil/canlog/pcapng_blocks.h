// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "hil/canlog/log_format.h"
#include "hil/canlog/socketcan_packet.h"

namespace pipewright::hil {

/// pcapng (Wireshark's own format): blocks of type u32, length u32, content, length u32 again, in
/// the byte order that each section's head tells. Read are
///
///   0A0D0D0A  section head       byte order 1A2B3C4D; its interfaces are numbered anew
///   1         interface          link type; options: name (2), unit of time (9), offset (14)
///   6         packet             interface, time u64, bytes kept, bytes sent; options: flags (2)
///   2         packet, obsolete   the same in another order
///   3         simple packet      of the first interface, without time
///
/// and blocks of other types passed over, as are packets of interfaces that are not SocketCAN. That
/// none of the interfaces is, is told at the end.
class PcapngBlocks final : public LogFormat {
 public:
  static bool Begins(std::string_view begin);

  const char* name() const override { return "pcapng"; }
  std::size_t Fill(LogInput& in, std::span<LogFrame> out) override;

 private:
  struct Interface {
    bool can = false;
    std::uint8_t channel = 0;
    std::uint64_t units_per_second = 1'000'000;
    std::int64_t offset_s = 0;
  };
  struct Block {
    std::uint64_t at = 0;
    std::uint32_t type = 0;
    std::uint32_t bytes = 0;   ///< head and both lengths included
    std::string_view content;  ///< its beginning, at most kMostContent bytes
    bool cut = false;          ///< by the end of the file
  };
  /// Where a packet lies in its block's content.
  struct Packet {
    std::uint32_t interface = 0;
    std::uint64_t time = 0;
    std::size_t begin = 0;
    std::uint32_t bytes = 0;
    bool timed = true;
  };

  bool TakeBlock(LogInput& in, LogFrame& frame, bool& is_frame);
  bool Head(LogInput& in, Block& block);
  bool Damaged(LogInput& in, const Block& block, const char* expected);
  const char* TakeInterface(LogInput& in, const Block& block);
  const char* TakePacket(const Block& block, LogFrame& frame, bool& is_frame);
  bool FindPacket(const Block& block, Packet& packet) const;
  LogDirection DirectionOf(const Block& block, std::size_t options) const;

  /// Calls use(code, value) for each option from byte `at` of `content` on.
  template <typename Use>
  void ForEachOption(std::string_view content, std::size_t at, Use&& use) const;

  CaptureNumbers numbers_;
  std::vector<Interface> interfaces_;
  bool any_can_ = false;
  int other_link_type_ = -1;  ///< of the first interface that is not SocketCAN
  bool ended_ = false;
};

}  // namespace pipewright::hil
