// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/ctrl/robot_program/device_bench.h"

namespace pipewright::bench {

/// Limits of the nine axes, m/s and rad/s. Written here by hand: what the product's own tables say
/// is what is judged.
inline constexpr double kSpeedMax[] = {0.4, 1, 1, 1, 1, 1, 1, 1, 1};
inline constexpr double kAccelerationMax[] = {0.8, 2, 10, 10, 10, 10, 10, 10, 10};

/// Whether what went over the wire is lawful, by the bytes alone. The limits are the robot's as it
/// is operated: base 0.4 m/s and 0.8 m/s^2, 1 rad/s and 2 rad/s^2; each joint 1 rad/s and
/// 10 rad/s^2. Of the velocity u of each of the nine axes:
///
///   speed         |u| <= u_max
///   acceleration  over any time T, |u| grows by no more than a_max (T + slack)
///
/// slack: two control periods (the base's frames go every second cycle) and 20 ms that a frame may
/// wait for the wire. A reversal grows from zero. Towards zero any step is lawful: a fault commands
/// zero at once, and the devices have ramps of their own. One unit of each frame is allowed for
/// rounding.
class CommandJudge {
 public:
  /// In the order in which the wire carried them.
  void Take(const test::SentTwist& sent);
  void Take(const test::SentJoint& sent);
  /// All that the bench has kept, which is then forgotten there.
  void TakeAll(test::DeviceBench& bench);

  std::uint64_t unlawful() const { return unlawful_; }
  /// The last unlawful one, in words.
  const std::string& why() const { return why_; }
  std::uint64_t commands() const { return commands_; }

 private:
  struct Axis {
    double u = 0;
    double credit = 0;  ///< that |u| may grow by at once
    Time stamp{};
    bool seen = false;
  };

  void Check(int axis, double u, double unit, Time stamp);

  std::array<Axis, 9> axes_;
  std::uint64_t commands_ = 0;
  std::uint64_t unlawful_ = 0;
  std::string why_;
};

}  // namespace pipewright::bench
