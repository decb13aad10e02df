// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "platform/core/time.h"

namespace pipewright::can {

/// A classic CAN frame. Ids have 11 bits, or 29 when extended.
struct Frame {
  std::uint32_t id = 0;
  std::uint8_t dlc = 0;  ///< payload bytes, 0 to 8
  bool extended = false;
  bool remote = false;  ///< RTR: no payload
  bool error = false;   ///< an error frame of the controller; id holds the error class bits
  std::array<std::uint8_t, 8> data{};
  Time stamp{};  ///< set by the receiving bus; not part of equality

  friend constexpr bool operator==(const Frame& a, const Frame& b) {
    return a.id == b.id && a.dlc == b.dlc && a.extended == b.extended && a.remote == b.remote &&
           a.error == b.error && a.data == b.data;
  }
};

}  // namespace pipewright::can
