// SPDX-License-Identifier: MIT
#pragma once

#include "platform/can/frame.h"

namespace pipewright::can {

/// Bits of `frame` on the wire, from start of frame through the interframe space, with the stuff
/// bits that its id, payload and checksum really cause (ISO 11898-1, 10.4 and 10.5):
///
///   47 + 8 n + stuff bits with an 11-bit id, 67 + 8 n + stuff bits with a 29-bit one
///
/// n payload bytes; a remote frame has none.
int FrameBits(const Frame& frame);

}  // namespace pipewright::can
