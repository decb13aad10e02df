// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "platform/can/frame.h"

namespace pipewright::timing {

/// Which table a frame is read by.
enum class BusName : std::uint8_t { kBase, kArm };

/// How far two frames sent are apart: the largest difference of a quantity's wire value, in least
/// significant bits. Nothing when they differ in more than quantities: in id, length, a code, or a
/// bit that no signal claims.
std::optional<std::int64_t> LsbDifference(BusName bus, const can::Frame& a, const can::Frame& b);

}  // namespace pipewright::timing
