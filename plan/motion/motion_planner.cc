// SPDX-License-Identifier: MIT
#include "plan/motion/motion_planner.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

double Duration_s(const Configuration& a, const Configuration& b) {
  return Edge(a, b, SpeedsOf(TracerUf7())).duration_s();
}

bool SameBase(const Configuration& a, const Configuration& b) {
  constexpr double kSame = 1e-6;
  return (a.head<2>() - b.head<2>()).cwiseAbs().maxCoeff() < kSame &&
         std::abs(WrapAngle(a(2) - b(2))) < kSame;
}

/// The base of one and the joints of another.
Configuration Compose(const Configuration& base, const ArmVector& joints) {
  Configuration q = base;
  q.tail<kArmJoints>() = joints;
  return q;
}

}  // namespace

MotionPlanner::MotionPlanner(const MotionPlannerConfig& config)
    : config_(config), search_(config.node_capacity, config.reach_m, config.reach_rad) {
  assert(Valid(config));
  way_.reserve(2 * config.node_capacity);
  escape_.reserve(config.escapes + 1);
}

Status MotionPlanner::Plan(const Surroundings& around, const Configuration& from,
                           const Configuration& to, Rng& rng, Path& path, double* duration_s) {
  path.clear();
  *duration_s = 0;
  if (!from.allFinite() || !to.allFinite()) {
    return Status::kOutOfRange;
  }
  const CollisionChecker checker(around, config_.collision);
  const bool inside = !checker.Free(from);
  if (!checker.Free(to) || (inside && !Escape(checker, from, rng))) {
    return Status::kInfeasible;
  }
  const Configuration start = inside ? escape_.back().q : from;
  if (const Status status = Find(checker, start, to, rng); status != Status::kOk) {
    return status;
  }
  Prune(checker);
  Shorten(checker, rng);
  if (inside && !AppendEscape(path)) {
    return Status::kFull;
  }
  for (std::size_t i = 0; i < way_.size(); ++i) {
    // Trees grow from both ends; the half that was grown backwards is checked as it will be run.
    if (i > 0 && !checker.FreeEdge(way_[i - 1], way_[i])) {
      return Status::kIterationLimit;
    }
    if (!path.push_back(way_[i])) {
      return Status::kFull;
    }
  }
  *duration_s = PathDuration(path);
  return Status::kOk;
}

Status MotionPlanner::Leave(const Surroundings& around, const Configuration& from, Rng& rng,
                            Path& path) {
  path.clear();
  if (!from.allFinite()) {
    return Status::kOutOfRange;
  }
  const CollisionChecker checker(around, config_.collision);
  if (checker.Free(from) || !Escape(checker, from, rng)) {
    return Status::kInfeasible;
  }
  return AppendEscape(path) && path.push_back(escape_.back().q) ? Status::kOk : Status::kFull;
}

bool MotionPlanner::Try(const CollisionChecker& checker,
                        std::initializer_list<Configuration> waypoints) {
  way_.assign(waypoints.begin(), waypoints.end());
  for (std::size_t i = 1; i < way_.size(); ++i) {
    if (!checker.FreeEdge(way_[i - 1], way_[i])) {
      return false;
    }
  }
  return true;
}

bool MotionPlanner::Simple(const CollisionChecker& checker, const Configuration& from,
                           const Configuration& to) {
  if (Try(checker, {from, to})) {
    return true;
  }
  const ArmVector home = HomeJoints(TracerUf7());
  if (SameBase(from, to)) {
    return Try(checker, {from, Compose(from, home), to});
  }
  return Try(checker, {from, Compose(from, to.tail<kArmJoints>()), to}) ||
         Try(checker, {from, Compose(to, from.tail<kArmJoints>()), to}) ||
         Try(checker, {from, Compose(from, home), Compose(to, home), to});
}

/// Grows a tree from `from`, on whose edges nothing comes nearer than at `from`, until it meets a
/// free configuration.
bool MotionPlanner::Escape(const CollisionChecker& checker, const Configuration& from, Rng& rng) {
  const CollisionChecker relaxed = checker.RelaxedTo(from);
  constexpr double kFirstReach = 0.1;  // of an extension; it grows with the attempts
  escape_.assign(1, {from, -1});
  for (int i = 0; i < config_.escapes; ++i) {
    const double reach = std::min(1.0, kFirstReach + 4.0 * i / config_.escapes);
    const double reach_rad = reach * config_.reach_rad;
    const bool at_once = i < config_.escapes / 16;  // over one edge, if that will do
    const int parent =
        at_once ? 0 : static_cast<int>(rng.Uniform(0, static_cast<double>(escape_.size())));
    const Configuration a = escape_[parent].q;
    Configuration q = a;
    if (i % 2 == 1) {
      // Turned first: no drive along a wall leads away from it.
      const double drive_m = reach * rng.Uniform(-config_.reach_m, config_.reach_m);
      q(2) += rng.Uniform(-reach_rad, reach_rad);
      q(0) += drive_m * std::cos(q(2));
      q(1) += drive_m * std::sin(q(2));
    }
    if (i % 4 != 1) {
      for (int j = 0; j < kArmJoints; ++j) {
        q(3 + j) += rng.Uniform(-reach_rad, reach_rad);
      }
    }
    if (relaxed.FreeEdge(a, q)) {
      escape_.push_back({q, parent});
      if (checker.Free(q)) {
        return true;
      }
    }
  }
  return false;
}

/// The waypoints from the tree's root to the parent of its last node.
bool MotionPlanner::AppendEscape(Path& path) const {
  int edges = 0;
  for (int i = static_cast<int>(escape_.size()) - 1; escape_[i].parent >= 0; ++edges) {
    i = escape_[i].parent;
  }
  for (; edges > 0; --edges) {
    int i = static_cast<int>(escape_.size()) - 1;
    for (int up = 0; up < edges; ++up) {
      i = escape_[i].parent;
    }
    if (!path.push_back(escape_[i].q)) {
      return false;
    }
  }
  return true;
}

Status MotionPlanner::Find(const CollisionChecker& checker, const Configuration& from,
                           const Configuration& to, Rng& rng) {
  if (Simple(checker, from, to)) {
    return Status::kOk;
  }
  if (SameBase(from, to)) {
    const Status status =
        search_.Search(checker, from, to, true, config_.iterations / 2, rng, way_);
    if (status != Status::kIterationLimit) {
      return status;
    }
  }
  return search_.Search(checker, from, to, false, config_.iterations, rng, way_);
}

/// Leaves out waypoints, many at a time first.
void MotionPlanner::Prune(const CollisionChecker& checker) {
  for (int i = 0; i + 2 < static_cast<int>(way_.size()); ++i) {
    for (int j = static_cast<int>(way_.size()) - 1; j > i + 1; j = i + (j - i) / 2) {
      double along_s = 0;
      for (int e = i; e < j; ++e) {
        along_s += Duration_s(way_[e], way_[e + 1]);
      }
      if (Duration_s(way_[i], way_[j]) <= along_s && checker.FreeEdge(way_[i], way_[j])) {
        way_.erase(way_.begin() + i + 1, way_.begin() + j);
        break;
      }
    }
  }
}

/// Cuts corners between random points of the way.
void MotionPlanner::Shorten(const CollisionChecker& checker, Rng& rng) {
  for (int k = 0; k < config_.shortcuts && way_.size() > 2; ++k) {
    const double last = static_cast<double>(way_.size() - 1);
    const double a = rng.Uniform(0, last);
    const double b = rng.Uniform(0, last);
    CutCorner(checker, std::min(a, b), std::max(a, b), k % 2 == 1);
  }
}

/// Joins the points a and b of the way (edge number and share of that edge; or the waypoints about
/// them) by one edge, if it is free and saves time.
bool MotionPlanner::CutCorner(const CollisionChecker& checker, double a, double b,
                              bool within_edges) {
  constexpr double kWorthwhile = 0.98;
  const int i = static_cast<int>(a);
  const int j = static_cast<int>(b);
  if (i == j || way_.size() >= Goal::kMaxWaypoints) {
    return false;
  }
  const Edge first(way_[i], way_[i + 1], SpeedsOf(TracerUf7()));
  const Edge second(way_[j], way_[j + 1], SpeedsOf(TracerUf7()));
  const double s_first = within_edges ? a - i : 0;
  const double s_second = within_edges ? b - j : 1;
  const Configuration p = within_edges ? first.At(s_first) : way_[i];
  const Configuration q = within_edges ? second.At(s_second) : way_[j + 1];
  double along_s = (1 - s_first) * first.duration_s() + s_second * second.duration_s();
  for (int e = i + 1; e < j; ++e) {
    along_s += Duration_s(way_[e], way_[e + 1]);
  }
  // What is left of the two edges is checked anew, for its steps fall on other points.
  if (Duration_s(p, q) > kWorthwhile * along_s || !checker.FreeEdge(p, q) ||
      (within_edges && !(checker.FreeEdge(way_[i], p) && checker.FreeEdge(q, way_[j + 1])))) {
    return false;
  }
  way_.erase(way_.begin() + i + 1, way_.begin() + j + 1);
  if (within_edges) {
    way_.insert(way_.begin() + i + 1, {p, q});
  }
  return true;
}

double PathDuration(const MotionPlanner::Path& path) {
  double duration_s = 0;
  for (int i = 1; i < path.size(); ++i) {
    duration_s += Duration_s(path[i - 1], path[i]);
  }
  return duration_s;
}

}  // namespace pipewright
