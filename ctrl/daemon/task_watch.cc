// SPDX-License-Identifier: MIT
#include "ctrl/daemon/task_watch.h"

namespace pipewright {

void TaskWatch::Start(Time now) {
  turns_ = stroked_ = TaskTurns{};
  control_at_ = mapping_at_ = planning_at_ = now;
}

void TaskWatch::See(const TaskTurns& turns, Time now) {
  control_at_ = turns.control != turns_.control ? now : control_at_;
  mapping_at_ = turns.mapping != turns_.mapping ? now : mapping_at_;
  planning_at_ = turns.planning != turns_.planning ? now : planning_at_;
  turns_ = turns;
}

const char* TaskWatch::Silent(Time now) const {
  return now - control_at_ > bounds_.control     ? "control"
         : now - mapping_at_ > bounds_.mapping   ? "mapping"
         : now - planning_at_ > bounds_.planning ? "planning"
                                                 : nullptr;
}

bool TaskWatch::MayStroke(Time now) const {
  return turns_.control != stroked_.control && turns_.mapping != stroked_.mapping &&
         Silent(now) == nullptr;
}

}  // namespace pipewright
