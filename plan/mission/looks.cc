// SPDX-License-Identifier: MIT
#include "plan/mission/looks.h"

#include "plan/cfnbv/proposals.h"

namespace pipewright {
namespace {

constexpr double kRandomLook_rad = 1;  ///< of each joint, to either side
constexpr int kHalvings = 2;           ///< of a look that has no path

ArmVector RandomLook(Rng& rng) {
  ArmVector look;
  for (int j = 0; j < kArmJoints; ++j) {
    look(j) = rng.Uniform(-kRandomLook_rad, kRandomLook_rad);
  }
  return look;
}

}  // namespace

Looks::Looks(const LooksConfig& config, const MotionPlannerConfig& motion, const GainConfig& camera)
    : config_(config),
      motion_(motion),
      pose_views_(config.last),
      camera_(LatticeCameraRays(camera)) {}

int Looks::Count() const {
  switch (kind_) {
    case LookKind::kFirst:
      return config_.first.size();
    case LookKind::kAgain:
      return config_.again;
    case LookKind::kLast:
      return best_.size();
  }
  return 0;
}

/// A way to look number next_; one of the first kinds is halved where there is none.
Status Looks::Plan(const Surroundings& around, const Configuration& from, Rng& rng, Goal& goal) {
  Configuration q = from;
  double duration_s = 0;
  if (kind_ == LookKind::kLast) {
    q.tail<kArmJoints>() = best_[next_];
    return motion_.Plan(around, from, q, rng, goal.path, &duration_s);
  }
  const ArmVector look = kind_ == LookKind::kAgain ? RandomLook(rng) : config_.first[next_];
  Status found = Status::kInfeasible;
  double share = 1;
  for (int i = 0; i <= kHalvings && found != Status::kOk; ++i, share /= 2) {
    q.tail<kArmJoints>() = about_ + share * look;
    found = motion_.Plan(around, from, q, rng, goal.path, &duration_s);
  }
  if (found != Status::kOk && kind_ == LookKind::kAgain) {
    found = motion_.Leave(around, from, rng, goal.path);
  }
  return found;
}

bool Looks::Next(const Surroundings& around, const Configuration& from, Rng& rng, Goal& goal) {
  if (kind_ == LookKind::kLast && next_ == 0) {
    const CollisionChecker checker(around, motion_.config().collision);
    pose_views_.Find(checker, from, camera_, rng, best_);
  }
  Status found = Status::kInfeasible;
  while (found != Status::kOk && next_ < Count()) {
    found = Plan(around, from, rng, goal);
    ++next_;
  }
  if (found != Status::kOk) {
    return false;
  }
  if (kind_ == LookKind::kLast) {
    next_ = Count();  // one is enough
  }
  const Viewpoint view = ViewpointOf(goal.path.back());
  goal.p_WS = view.X_WS.translation();
  goal.z_WS = view.X_WS.linear().col(2);
  return true;
}

}  // namespace pipewright
