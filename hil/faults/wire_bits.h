// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "platform/can/frame.h"

namespace pipewright::hil {

/// Bits of a data frame with an 11-bit id from its start to the end of its checksum, without stuff
/// bits (ISO 11898-1, 10.4): start, id, RTR, IDE, r0, DLC, payload, CRC.
constexpr int WireBits(const can::Frame& frame) {
  return 1 + 11 + 1 + 1 + 1 + 4 + 8 * frame.dlc + 15;
}

/// What a receiving controller makes of a frame of which the bits at `flipped` came the other way
/// round: nothing, unless its checksum agrees with what came. Stuff bits are left out: they find
/// more errors, and a few that only look like errors.
///
/// @param frame    a data frame with an 11-bit id
/// @param flipped  0 to WireBits(frame) - 1
/// @returns the frame as the controller hands it on; nothing when it drops it
std::optional<can::Frame> ReceiveFlipped(const can::Frame& frame, std::span<const int> flipped);

}  // namespace pipewright::hil
