// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "platform/can/frame.h"

namespace pipewright::can {

/// Classes of a controller's error frame, bits of its id. Source: linux/can/error.h.
namespace error_class {
inline constexpr std::uint32_t kBusOff = 0x040;
inline constexpr std::uint32_t kRestarted = 0x100;
}  // namespace error_class

/// The controller has left the bus, or is back after it had: frames were lost either way.
constexpr bool TellsBusOff(const Frame& frame) {
  return frame.error && (frame.id & (error_class::kBusOff | error_class::kRestarted)) != 0;
}

}  // namespace pipewright::can
