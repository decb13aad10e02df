// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "platform/can/tracer_messages.h"

namespace pipewright {

/// Whose numbers a base uses for its control modes; "sdk", "tracer12", "tracer20" or "mini".
/// @returns nullptr for any other name
inline const can::ControlModeCodes* ModeCodesByName(std::string_view name) {
  return name == "sdk"        ? &can::kModesSdk
         : name == "tracer12" ? &can::kModesTracer12
         : name == "tracer20" ? &can::kModesTracer20
         : name == "mini"     ? &can::kModesMini
                              : nullptr;
}

inline std::string ModeCodeNames() { return "sdk, tracer12, tracer20, mini"; }

}  // namespace pipewright
