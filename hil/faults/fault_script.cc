// SPDX-License-Identifier: MIT
#include "hil/faults/fault_script.h"

#include <utility>

namespace pipewright::hil {

void FaultScript::AdvanceTo(Time now) {
  while (!actions_.empty() && actions_.begin()->first <= now) {
    const std::function<void()> action = std::move(actions_.begin()->second);
    actions_.erase(actions_.begin());
    action();
  }
}

}  // namespace pipewright::hil
