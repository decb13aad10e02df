// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "plan/goal.h"
#include "plan/motion/collision.h"
#include "plan/motion/edge.h"
#include "plan/motion/surroundings.h"
#include "platform/core/rng.h"
#include "platform/core/status.h"

namespace pipewright {

struct MotionPlannerConfig {
  CollisionConfig collision;
  int node_capacity = 2000;  ///< of each of the two trees
  int iterations = 1500;     ///< samples drawn, at most
  int shortcuts = 60;        ///< attempts to cut a corner, at most
  int escapes = 60;          ///< attempts to leave a start that is inside the margins
  double reach_m = 0.4;      ///< an extension's longest drive
  double reach_rad = 0.8;    ///< and its largest turn of the base or of a joint
};

constexpr bool Valid(const MotionPlannerConfig& c) {
  return Valid(c.collision) && 2 <= c.node_capacity && 0 <= c.iterations && 0 <= c.shortcuts &&
         0 <= c.escapes && 0 < c.reach_m && 0 < c.reach_rad;
}

/// Ways between configurations, by RRT-Connect (Kuffner, LaValle 2000) over q with the edges of
/// plan/motion/edge.h: first the straight edge, then the arm alone if the base stays, then all.
/// What is found is shortened by cutting corners. All memory is taken at construction.
class MotionPlanner {
 public:
  using Path = FixedVector<Configuration, Goal::kMaxWaypoints>;

  explicit MotionPlanner(const MotionPlannerConfig& config = {});
  ~MotionPlanner();
  MotionPlanner(const MotionPlanner&) = delete;
  MotionPlanner& operator=(const MotionPlanner&) = delete;

  /// A path from `from` (its first waypoint) to `to` (its last), every edge free. The start may lie
  /// a little inside the margins: the first edge then leads out of them.
  ///
  /// @param duration_s  set to the path's time at operating speeds, without ramps
  /// @returns kOk; kOutOfRange: an argument is not finite; kInfeasible: `to` is not free, or the
  ///          start cannot be left; kFull: the node store or the path is full; kIterationLimit
  Status Plan(const Surroundings& around, const Configuration& from, const Configuration& to,
              Rng& rng, Path& path, double* duration_s);

  const MotionPlannerConfig& config() const { return config_; }

 private:
  struct Trees;

  MotionPlannerConfig config_;
  std::unique_ptr<Trees> trees_;
};

/// Sum of the edges' times at operating speeds.
double PathDuration(const MotionPlanner::Path& path);

}  // namespace pipewright
