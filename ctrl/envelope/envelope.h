// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "platform/core/status.h"
#include "platform/robot/robot.h"

namespace pipewright {

/// Limits of what may go on the bus. Controls u = [v, omega, q1' ... q7'], m/s and rad/s.
struct EnvelopeConfig {
  Duration period = std::chrono::milliseconds(10);
  Duration state_timeout = std::chrono::milliseconds(50);
  Controls u_max = Controls::Zero();  ///< |u| <= u_max
  Controls a_max = Controls::Zero();  ///< |u - last u| <= a_max period, m/s^2 and rad/s^2
  ArmVector q_min = ArmVector::Zero();
  ArmVector q_max = ArmVector::Zero();
  double braking_share = 0.8;  ///< of a_max, on which the distance to a joint limit is budgeted
  Duration longest_gap = std::chrono::milliseconds(200);  ///< braking makes up for at most so much
  int overruns_max = 5;  ///< cycles in a row, each half a period late or more, that stop the robot
};

bool Valid(const EnvelopeConfig& c);

/// Steps on which each reason changed the command. One step may count for several.
struct EnvelopeCounters {
  std::uint64_t steps = 0;
  std::uint64_t not_finite = 0;     ///< a wanted value was NaN or infinite: stop
  std::uint64_t stale = 0;          ///< the state is older than its timeout, or of the future: stop
  std::uint64_t invalid_state = 0;  ///< the state is not valid or not finite: stop
  std::uint64_t emergency_stop = 0;  ///< pressed, or not yet re-armed: stop
  std::uint64_t overruns = 0;        ///< steps half a period late or more
  std::uint64_t overrun_stop = 0;    ///< too many of them in a row: stop
  std::uint64_t speed = 0;
  std::uint64_t acceleration = 0;
  std::uint64_t joint_position = 0;
};

struct EnvelopeResult {
  Controls u = Controls::Zero();  ///< to be sent
  bool changed = false;           ///< u is not what was wanted
  bool stopping = false;          ///< the wish was put aside: u ramps to zero, or is zero
};

/// The last word before the bus: whatever is wanted and whatever is known, the command that leaves
/// is finite, within speed, within acceleration of the command before it, and lets every joint
/// stop before its limit. An emergency stop latches until Rearm().
///
/// A stop takes the time it takes, however seldom Step is called: u comes nearer to zero by a_max
/// times the time since the last command, longest_gap at most. All other changes stay within
/// a_max period. Cycles that are late one after the other stop the robot until one is on time.
class Envelope {
 public:
  explicit Envelope(const EnvelopeConfig& config);

  /// Once per period. The result counts as sent.
  EnvelopeResult Step(const Controls& wanted, const RobotState& state, Time now);

  /// Clears the emergency-stop latch. kFault: it is still pressed. kOk otherwise.
  Status Rearm();

  bool latched() const { return latched_; }
  const EnvelopeCounters& counters() const { return counters_; }

 private:
  Duration Elapsed(Time now);
  bool MustStop(const Controls& wanted, const RobotState& state, Time now);
  Controls LimitSpeed(const Controls& wanted);
  Controls KeepJointsInside(const Controls& u, const RobotState& state, Time now) const;

  EnvelopeConfig config_;
  Controls last_ = Controls::Zero();
  Time last_step_{};
  bool stepped_ = false;
  int overruns_in_row_ = 0;
  EnvelopeCounters counters_;
  bool pressed_ = false;
  bool latched_ = false;
};

}  // namespace pipewright
