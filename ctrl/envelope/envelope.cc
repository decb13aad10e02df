// SPDX-License-Identifier: MIT
#include "ctrl/envelope/envelope.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "platform/core/usable.h"

namespace pipewright {
namespace {

/// The fastest approach to a limit `room` ahead from which a joint, after `reaction_s` at that
/// speed, still stops before it at the rate a:  u T + u^2 / (2 a) = room.
double BrakingSpeed(double room, double reaction_s, double a) {
  const double at = a * reaction_s;
  return room > 0 ? std::sqrt(at * at + 2 * a * room) - at : 0;
}

/// u towards zero, no faster than `step` allows.
double TowardsZero(double u, double step) {
  return u > 0 ? std::max(u - step, 0.0) : std::min(u + step, 0.0);
}

}  // namespace

bool Valid(const EnvelopeConfig& c) {
  const auto usable = [](const auto& v) {
    return v.unaryExpr([](double x) { return Usable(x) ? 1.0 : 0.0; }).minCoeff() > 0;
  };
  return c.period > Duration::zero() && Usable(c.period) && c.state_timeout > Duration::zero() &&
         Usable(c.state_timeout) && usable(c.u_max) && usable(c.a_max) &&
         (c.u_max.array() > 0).all() && (c.a_max.array() > 0).all() && usable(c.q_min) &&
         usable(c.q_max) && (c.q_min.array() < c.q_max.array()).all() && 0 < c.braking_share &&
         c.braking_share <= 1 && Usable(c.braking_share) && c.longest_gap >= c.period &&
         Usable(c.longest_gap) && c.overruns_max >= 1;
}

Envelope::Envelope(const EnvelopeConfig& config) : config_(config) { assert(Valid(config)); }

EnvelopeResult Envelope::Step(const Controls& wanted, const RobotState& state, Time now) {
  ++counters_.steps;
  EnvelopeResult result;
  const Duration elapsed = Elapsed(now);
  result.stopping = MustStop(wanted, state, now);
  if (result.stopping) {
    const double braking_s = ToSeconds(std::min(elapsed, config_.longest_gap));
    for (int i = 0; i < kControls; ++i) {
      result.u[i] = TowardsZero(last_[i], config_.a_max[i] * braking_s);
    }
  } else {
    const Controls max_step = config_.a_max * ToSeconds(config_.period);
    const Controls slow = LimitSpeed(wanted);
    const Controls smooth = slow.cwiseMax(last_ - max_step).cwiseMin(last_ + max_step);
    counters_.acceleration += smooth != slow;
    result.u = KeepJointsInside(smooth, state, now);
    counters_.joint_position += result.u != smooth;
  }
  result.changed = result.u != wanted;  // NaN differs from all
  last_ = result.u;
  return result;
}

/// Time since the last command; one period before there is one, and where the clock has not moved
/// on: a ramp goes on in any case.
Duration Envelope::Elapsed(Time now) {
  const Duration since = now - last_step_;
  const bool known = stepped_ && since > Duration::zero();
  const bool late = known && since - config_.period >= config_.period / 2;
  overruns_in_row_ = late ? std::min(overruns_in_row_ + 1, config_.overruns_max) : 0;
  counters_.overruns += late;
  stepped_ = true;
  last_step_ = now;
  return known ? since : config_.period;
}

Status Envelope::Rearm() {
  if (pressed_) {
    return Status::kFault;
  }
  latched_ = false;
  return Status::kOk;
}

bool Envelope::MustStop(const Controls& wanted, const RobotState& state, Time now) {
  pressed_ = state.emergency_stop;
  latched_ = latched_ || pressed_;
  const bool unsound = !state.valid || !state.q.allFinite() || !state.u.allFinite();
  const Duration age = now - state.stamp;
  const bool stale = age > config_.state_timeout || age < -config_.period;
  const bool not_finite = !wanted.allFinite();
  const bool overrun = overruns_in_row_ >= config_.overruns_max;
  counters_.emergency_stop += latched_;
  counters_.invalid_state += unsound;
  counters_.stale += stale;
  counters_.not_finite += not_finite;
  counters_.overrun_stop += overrun;
  return latched_ || unsound || stale || not_finite || overrun;
}

/// Shrinks all controls alike: the direction of motion, on which the constraints were checked,
/// stays.
Controls Envelope::LimitSpeed(const Controls& wanted) {
  double excess = 1;
  for (int i = 0; i < kControls; ++i) {
    excess = std::max(excess, std::fabs(wanted[i]) / config_.u_max[i]);
  }
  if (excess <= 1) {
    return wanted;
  }
  ++counters_.speed;
  return (wanted / excess).cwiseMax(-config_.u_max).cwiseMin(config_.u_max);
}

/// The position that counts is where the joint may be by now: the state is `age` old, the drive may
/// follow one period late, and over that time the joint moved at what was measured or commanded
/// last, or faster by what acceleration allows. The new command acts for one period, and again the
/// drive may be late by one. A position limit beats the acceleration limit.
Controls Envelope::KeepJointsInside(const Controls& u, const RobotState& state, Time now) const {
  const double age_s = std::max(0.0, ToSeconds(now - state.stamp));
  const double period_s = ToSeconds(config_.period);
  Controls inside = u;
  for (int i = 0; i < kArmJoints; ++i) {
    const int c = kControls - kArmJoints + i;
    const double q = state.q[kDof - kArmJoints + i];
    const double a = config_.braking_share * config_.a_max[c];
    const double unseen = config_.a_max[c] * (age_s + period_s) * (age_s + period_s) / 2;
    const double up = std::max({0.0, state.u[c], last_[c]}) * age_s + unseen;
    const double down = std::min({0.0, state.u[c], last_[c]}) * age_s - unseen;
    const double highest = BrakingSpeed(config_.q_max[i] - (q + up), 2 * period_s, a);
    const double lowest = -BrakingSpeed(q + down - config_.q_min[i], 2 * period_s, a);
    inside[c] = std::clamp(u[c], lowest, highest);
  }
  return inside;
}

}  // namespace pipewright
