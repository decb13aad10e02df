// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>

#include "platform/robot/robot.h"

namespace pipewright {

/// The last states of the control task, so that a sensor frame finds the pose of its own instant.
class StateHistory {
 public:
  static constexpr int kStates = 32;

  /// States come in the order of time; one that is not newer replaces nothing and is ignored.
  void Add(const RobotState& state);

  /// The configuration at `when`: linear between the two states around it, or the newest one moved
  /// on by its velocity for at most max_extrapolation. Nothing when the history does not reach
  /// there, or the state there is not valid.
  std::optional<Configuration> At(Time when, Duration max_extrapolation) const;

 private:
  const RobotState& Newest(int age) const { return states_[(next_ + kStates - 1 - age) % kStates]; }

  std::array<RobotState, kStates> states_{};
  int next_ = 0;
  int count_ = 0;
};

/// q after dt at constant u, base along its exact arc.
Configuration Advance(const Configuration& q, const Controls& u, double dt_s);

}  // namespace pipewright
