// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string_view>

#include "hil/canlog/log_format.h"

namespace pipewright::hil {

/// The text format that `begin`, the first bytes of a log, is in; none: no reader. Its first line
/// that is a frame decides.
///
/// candump -t d writes the time since the frame before, -t z that since the first: their lines look
/// the same. Stamps are taken for times between frames when more than one in ten of those in
/// `begin` is less than the one before it, or when `deltas` says so.
std::unique_ptr<LogFormat> TextFormatOf(std::string_view begin, bool deltas);

}  // namespace pipewright::hil
