// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "platform/linux/realtime.h"

namespace pipewright {

/// What the system grants a thread that asks, found out by one that does nothing else.
RealtimeGrant TryRealtime(const RealtimeRequest& request);

/// What was refused and how to grant it, a line each; none when all was granted.
std::vector<std::string> RefusalWords(const RealtimeGrant& grant, const RealtimeRequest& request);

}  // namespace pipewright
