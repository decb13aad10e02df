// SPDX-License-Identifier: MIT
#pragma once

#include <initializer_list>
#include <vector>

#include "plan/goal.h"
#include "plan/motion/collision.h"
#include "plan/motion/edge.h"
#include "plan/motion/rrt_connect.h"
#include "plan/motion/surroundings.h"
#include "platform/core/rng.h"
#include "platform/core/status.h"

namespace pipewright {

struct MotionPlannerConfig {
  CollisionConfig collision = {};
  int node_capacity = 2000;  ///< of each of the two trees
  int iterations = 1000;     ///< samples drawn, at most
  int shortcuts = 60;        ///< attempts to cut a corner, at most
  int escapes = 1000;        ///< attempts to leave a start that is inside the margins
  double reach_m = 0.4;      ///< an extension's longest drive
  double reach_rad = 0.8;    ///< and its largest turn of the base or of a joint
};

constexpr bool Valid(const MotionPlannerConfig& c) {
  return Valid(c.collision) && 2 * Goal::kMaxWaypoints <= c.node_capacity && 0 <= c.iterations &&
         0 <= c.shortcuts && 0 <= c.escapes && 0 < c.reach_m && 0 < c.reach_rad;
}
static_assert(Valid(MotionPlannerConfig{}));

/// Ways between configurations: a few simple ones first (straight; the arm before or after the
/// base; over the home posture), then RRT-Connect, with the arm alone if the base need not move.
/// What is found is shortened by cutting corners. All memory is taken at construction.
class MotionPlanner {
 public:
  using Path = FixedVector<Configuration, Goal::kMaxWaypoints>;

  explicit MotionPlanner(const MotionPlannerConfig& config = {});

  /// A path from `from` (its first waypoint) to `to` (its last), every edge free. The start may lie
  /// inside the margins: the first edges then lead out of them, and never deeper in.
  ///
  /// @param duration_s  the path's time at operating speeds, without ramps
  /// @returns kOk; kOutOfRange: an argument is not finite; kInfeasible: `to` is not free, or the
  ///          start cannot be left; kFull: the node store or the path is; kIterationLimit
  Status Plan(const Surroundings& around, const Configuration& from, const Configuration& to,
              Rng& rng, Path& path, double* duration_s);

  /// Out of the margins by the first way that leads there, wherever that is.
  /// @returns kOk; kInfeasible: there is none, or the start is free; kOutOfRange; kFull
  Status Leave(const Surroundings& around, const Configuration& from, Rng& rng, Path& path);

  const MotionPlannerConfig& config() const { return config_; }

 private:
  bool Try(const CollisionChecker& checker, std::initializer_list<Configuration> waypoints);
  bool Simple(const CollisionChecker& checker, const Configuration& from, const Configuration& to);
  bool Escape(const CollisionChecker& checker, const Configuration& from, Rng& rng);
  bool AppendEscape(Path& path) const;
  Status Find(const CollisionChecker& checker, const Configuration& from, const Configuration& to,
              Rng& rng);
  void Prune(const CollisionChecker& checker);
  void Shorten(const CollisionChecker& checker, Rng& rng);
  bool CutCorner(const CollisionChecker& checker, double a, double b, bool within_edges);

  MotionPlannerConfig config_;
  RrtConnect search_;
  std::vector<Configuration> way_;  ///< the path in hand; its capacity is fixed
  struct EscapeNode {
    Configuration q;
    int parent = -1;
  };
  std::vector<EscapeNode> escape_;  ///< the tree out of the margins; its capacity is fixed
};

/// Sum of the edges' times at operating speeds. [s]
double PathDuration(const MotionPlanner::Path& path);

}  // namespace pipewright
