// SPDX-License-Identifier: MIT
#pragma once

namespace pipewright::hil {

/// From now on SIGINT and SIGTERM end nothing by themselves; Interrupted() tells of them.
void CatchInterrupts();

bool Interrupted();

}  // namespace pipewright::hil
