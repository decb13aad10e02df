// SPDX-License-Identifier: MIT
#include "platform/robot/state_history.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pipewright {

Configuration Advance(const Configuration& q, const Controls& u, double dt_s) {
  Configuration next = q;
  const double turn = u(1) * dt_s;
  // The chord of the arc: length v dt sinc(turn / 2), along the mean heading.
  const double half = turn / 2;
  const double sinc = std::abs(half) < 1e-6 ? 1 - half * half / 6 : std::sin(half) / half;
  next(0) += u(0) * dt_s * sinc * std::cos(q(2) + half);
  next(1) += u(0) * dt_s * sinc * std::sin(q(2) + half);
  next(2) += turn;
  next.tail<kArmJoints>() += u.tail<kArmJoints>() * dt_s;
  return next;
}

void StateHistory::Add(const RobotState& state) {
  if (count_ > 0 && state.stamp <= Newest(0).stamp) {
    return;
  }
  states_[next_] = state;
  next_ = (next_ + 1) % kStates;
  count_ = std::min(count_ + 1, kStates);
}

std::optional<Configuration> StateHistory::At(Time when, Duration max_extrapolation) const {
  if (count_ == 0) {
    return std::nullopt;
  }
  const RobotState& newest = Newest(0);
  if (when >= newest.stamp) {
    if (!newest.valid || when - newest.stamp > max_extrapolation) {
      return std::nullopt;
    }
    return Advance(newest.q, newest.u, ToSeconds(when - newest.stamp));
  }
  for (int age = 1; age < count_; ++age) {
    const RobotState& before = Newest(age);
    const RobotState& after = Newest(age - 1);
    if (before.stamp <= when) {
      if (!before.valid || !after.valid) {
        return std::nullopt;
      }
      const double share = ToSeconds(when - before.stamp) / ToSeconds(after.stamp - before.stamp);
      Configuration step = after.q - before.q;
      step(2) = std::remainder(step(2), 2 * std::numbers::pi);
      return before.q + share * step;
    }
  }
  return std::nullopt;
}

}  // namespace pipewright
