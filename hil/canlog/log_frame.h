// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "platform/can/frame.h"

namespace pipewright::hil {

enum class LogDirection : std::uint8_t { kUnknown, kReceived, kSent };

/// One record of a log: a frame of classic CAN or CAN FD, or an error message of the controller.
struct LogFrame {
  std::int64_t stamp_ns = 0;  ///< by the log's own clock; 0 when it gives none
  std::uint32_t id = 0;       ///< of an error message: its class bits (linux/can/error.h)
  std::uint8_t length = 0;    ///< payload bytes, 0 to 64; of a remote frame: those asked for
  std::uint8_t channel = 0;   ///< index into the log's channel names
  bool stamped = false;
  bool extended = false;
  bool remote = false;
  bool error = false;
  bool fd = false;
  bool bitrate_switch = false;
  bool error_passive = false;  ///< CAN FD's ESI
  LogDirection direction = LogDirection::kUnknown;
  /// 0 in the first 8 bytes past `length`, anything in those after.
  std::array<std::uint8_t, 64> data;

  /// Whether payload bytes are in `data`.
  int payload_bytes() const { return remote ? 0 : length; }
};

/// What both hold that travelled on the bus: neither time nor channel nor direction.
inline bool SameOnTheWire(const LogFrame& a, const LogFrame& b) {
  return a.id == b.id && a.length == b.length && a.extended == b.extended && a.remote == b.remote &&
         a.error == b.error && a.fd == b.fd && a.bitrate_switch == b.bitrate_switch &&
         a.error_passive == b.error_passive &&
         std::equal(a.data.begin(), a.data.begin() + a.payload_bytes(), b.data.begin());
}

/// The codec's frame. @pre not CAN FD
inline can::Frame ClassicFrame(const LogFrame& from) {
  can::Frame frame{.id = from.id,
                   .dlc = from.length,
                   .extended = from.extended,
                   .remote = from.remote,
                   .error = from.error};
  std::copy_n(from.data.begin(), frame.data.size(), frame.data.begin());
  frame.stamp = Time(Duration(from.stamp_ns));
  return frame;
}

}  // namespace pipewright::hil
