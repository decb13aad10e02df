// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "hil/canlog/log_format.h"
#include "hil/canlog/socketcan_packet.h"

namespace pipewright::hil {

/// pcap (tcpdump, Wireshark) of link type 227. Little-endian or big, by its magic number, which
/// also tells whether times are in µs (A1B2C3D4) or ns (A1B23C4D):
///
///   head     magic u32, major u16, minor u16, zone u32, accuracy u32, most bytes u32, link type
///   u32 packet   seconds u32, µs or ns u32, bytes kept u32, bytes sent u32, the bytes kept
class PcapPackets final : public LogFormat {
 public:
  static bool Begins(std::string_view begin);

  const char* name() const override { return "pcap"; }
  std::size_t Fill(LogInput& in, std::span<LogFrame> out) override;

 private:
  bool TakeHead(LogInput& in);
  /// False: nothing more can be read.
  bool TakePacket(LogInput& in, LogFrame& frame, bool& is_frame);

  bool open_ = false;
  bool ended_ = false;
  CaptureNumbers numbers_;
  std::int64_t ns_per_unit_ = 1;
  std::uint8_t channel_ = 0;
};

/// A packet longer than this is taken for damage.
inline constexpr std::uint32_t kMostPacketBytes = 1 << 18;

}  // namespace pipewright::hil
