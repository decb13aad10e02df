// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/robot_program/control_task.h"
#include "ctrl/robot_program/perceived.h"
#include "plan/mission/mission.h"

namespace pipewright {

/// The third of the three tasks: runs the mission on the newest map.
class PlanningTask {
 public:
  PlanningTask(const MissionConfig& config, const MapConfig& map) : mission_(config, map) {}

  const MissionOutput& Step(Time now, const MapSnapshot& snapshot, const ControlReport& report,
                            bool device_fault) {
    output_ = mission_.Step({.robot = report.state,
                             .progress = report.progress,
                             .map = snapshot.map,
                             .field = snapshot.field,
                             .scene = snapshot.scene,
                             .device_fault = device_fault,
                             .pose_doubted = report.pose.doubted,
                             .pose_lost = report.pose.lost},
                            now);
    return output_;
  }

  const Goal& goal() const { return mission_.goal(); }
  const MissionOutput& output() const { return output_; }
  std::span<const VoxelIndex> NewResidual() const { return mission_.NewResidual(); }

 private:
  Mission mission_;
  MissionOutput output_;
};

}  // namespace pipewright
