// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "platform/core/status.h"

namespace pipewright::can {

/// Bytes that are enough for DescribeTables.
inline constexpr int kTableTextBytes = 16 * 1024;

/// Writes both bus tables as text, one line a frame and one a signal, for a person to read.
/// Returns the length; kFull: `out` is too short.
Result<int> DescribeTables(std::span<char> out);

}  // namespace pipewright::can
