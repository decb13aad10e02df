// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "plan/mission/pose_views.h"
#include "plan/motion/motion_planner.h"

namespace pipewright {

enum class LookKind : std::uint8_t {
  kFirst,  ///< about the start, as configured
  kAgain,  ///< at random, when no view can be reached
  kLast,   ///< one, where most tells the base's pose, before the mission ends
};

struct LooksConfig {
  static constexpr int kMost = 16;

  /// Looks to take first: arm joint angles minus those at the start, rad. One without a path is
  /// halved until it has one, at most twice, and else left out. They are taken however much is
  /// known already: what is seen from the start is placed without an error of the wheels, and all
  /// that comes after finds itself among it.
  FixedVector<ArmVector, kMost> first;
  int again = 8;
  PoseViewsConfig last;
};

constexpr bool Valid(const LooksConfig& c) { return c.again >= 0 && Valid(c.last); }

/// Goals that only look: the arm moves, the base is at rest.
class Looks {
 public:
  Looks(const LooksConfig& config, const MotionPlannerConfig& motion, const GainConfig& camera);

  /// From here on Next() gives those of this kind, about the posture of q.
  void Begin(LookKind kind, const Configuration& q) {
    kind_ = kind;
    about_ = q.tail<kArmJoints>();
    next_ = 0;
  }

  /// The next look to which there is a way from `from`. @returns false: there are no more
  bool Next(const Surroundings& around, const Configuration& from, Rng& rng, Goal& goal);

  LookKind kind() const { return kind_; }

 private:
  int Count() const;
  Status Plan(const Surroundings& around, const Configuration& from, Rng& rng, Goal& goal);

  LooksConfig config_;
  MotionPlanner motion_;
  PoseViews pose_views_;
  RaySet camera_;
  PoseViews::Views best_;
  LookKind kind_ = LookKind::kFirst;
  ArmVector about_ = ArmVector::Zero();
  int next_ = 0;
};

}  // namespace pipewright
