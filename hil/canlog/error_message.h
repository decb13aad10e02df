// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include "hil/canlog/log_frame.h"

namespace pipewright::hil {

/// Writes an error message of SocketCAN in words, its classes and what its payload says of them
/// (linux/can/error.h): "bus off", "controller problem: receive warning", "no acknowledge".
/// @pre frame.error
void AppendErrorMessage(fmt::memory_buffer& to, const LogFrame& frame);

}  // namespace pipewright::hil
