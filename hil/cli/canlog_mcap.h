// SPDX-License-Identifier: MIT
#pragma once

#include "hil/cli/canlog_input.h"

namespace pipewright::hil {

/// `canlog export --mcap`: writes the log, and with `--depth` a run's depth frames, as ROS 2
/// messages into an MCAP file; see CanToRos and DepthToRos for what becomes of which frames. Prints
/// the topics. @returns the exit code
int CanlogMcap(LogSet& log, const CanlogOptions& options);

}  // namespace pipewright::hil
