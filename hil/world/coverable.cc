// SPDX-License-Identifier: MIT
#include "hil/world/coverable.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hil/world/clearance.h"
#include "platform/core/rng.h"

namespace pipewright::hil {
namespace {

constexpr double kCell_m = 0.05;
constexpr int kHeadings = 16;
constexpr double kHeading_rad = 2 * std::numbers::pi / kHeadings;

/// Spread of a variation: a few centimetres at the hand for each.
constexpr double kVaryBase_m = 0.06;
constexpr double kVaryYaw_rad = 0.15;
constexpr double kVaryJoint_rad = 0.25;

struct Posture {
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
  std::vector<double> joints_rad;
};

/// Base poses connected to the start, on a grid of x, y and heading over the map's floor.
class FreeFloor {
 public:
  FreeFloor(const Scenario& scenario, const RobotBodies& robot, ClearanceMeter& meter)
      : lo_(scenario.map.min_m.head<2>()),
        nx_(Cells(scenario.map.max_m.x() - scenario.map.min_m.x())),
        ny_(Cells(scenario.map.max_m.y() - scenario.map.min_m.y())),
        reached_(static_cast<std::size_t>(nx_) * ny_ * kHeadings, 0) {
    RobotBodies::Pose pose;
    const std::vector<double> joints =
        robot.joint_min_rad;  // no matter: only the base is asked for
    const auto free = [&](int cell) {
      const Posture at = Center(cell);
      robot.forward(at.x_m, at.y_m, at.yaw_rad, joints, pose);
      return !meter.Touches(pose.X_WL, 0);
    };
    Flood(scenario.start, free);
  }

  bool empty() const { return cells_.empty(); }

  Posture Draw(Rng& rng) const {
    Posture at = Center(cells_[rng.Index(static_cast<int>(cells_.size()))]);
    at.x_m += rng.Uniform(-0.5, 0.5) * kCell_m;
    at.y_m += rng.Uniform(-0.5, 0.5) * kCell_m;
    at.yaw_rad += rng.Uniform(-0.5, 0.5) * kHeading_rad;
    return at;
  }

  bool Reached(const Posture& at) const {
    const int cell = CellAt(at.x_m, at.y_m, at.yaw_rad);
    return cell >= 0 && reached_[cell] != 0;
  }

 private:
  static int Cells(double length_m) {
    return std::max(1, static_cast<int>(std::ceil(length_m / kCell_m - 1e-6)));
  }

  int CellAt(double x_m, double y_m, double yaw_rad) const {
    const double cx = std::floor((x_m - lo_.x()) / kCell_m);
    const double cy = std::floor((y_m - lo_.y()) / kCell_m);
    if (!(cx >= 0 && cx < nx_ && cy >= 0 && cy < ny_)) {
      return -1;
    }
    const int turn = static_cast<int>(std::lround(yaw_rad / kHeading_rad));
    const int heading = ((turn % kHeadings) + kHeadings) % kHeadings;
    return (static_cast<int>(cx) * ny_ + static_cast<int>(cy)) * kHeadings + heading;
  }

  Posture Center(int cell) const {
    const int heading = cell % kHeadings;
    const int y = cell / kHeadings % ny_;
    const int x = cell / kHeadings / ny_;
    return {
        lo_.x() + (x + 0.5) * kCell_m, lo_.y() + (y + 0.5) * kCell_m, heading * kHeading_rad, {}};
  }

  template <typename Free>
  void Flood(const StartPose& start, const Free& free) {
    std::vector<std::uint8_t> seen(reached_.size(), 0);
    const auto visit = [&](int x, int y, int heading) {
      if (x < 0 || x >= nx_ || y < 0 || y >= ny_) {
        return;
      }
      const int cell = (x * ny_ + y) * kHeadings + (heading + kHeadings) % kHeadings;
      if (seen[cell] == 0) {
        seen[cell] = 1;
        if (free(cell)) {
          reached_[cell] = 1;
          cells_.push_back(cell);
        }
      }
    };
    const int first = CellAt(start.x_m, start.y_m, start.yaw_rad);
    if (first < 0) {
      return;
    }
    visit(first / kHeadings / ny_, first / kHeadings % ny_, first % kHeadings);
    for (std::size_t next = 0; next < cells_.size(); ++next) {
      const int heading = cells_[next] % kHeadings;
      const int y = cells_[next] / kHeadings % ny_;
      const int x = cells_[next] / kHeadings / ny_;
      for (int d = -1; d <= 1; d += 2) {
        visit(x + d, y, heading);
        visit(x, y + d, heading);
        visit(x, y, heading + d);
      }
    }
  }

  Eigen::Vector2d lo_;
  int nx_;
  int ny_;
  std::vector<std::uint8_t> reached_;
  std::vector<int> cells_;
};

Posture Vary(const Posture& from, const RobotBodies& robot, Rng& rng) {
  Posture to = from;
  to.x_m += kVaryBase_m * rng.Normal();
  to.y_m += kVaryBase_m * rng.Normal();
  to.yaw_rad += kVaryYaw_rad * rng.Normal();
  for (std::size_t i = 0; i < to.joints_rad.size(); ++i) {
    to.joints_rad[i] = std::clamp(to.joints_rad[i] + kVaryJoint_rad * rng.Normal(),
                                  robot.joint_min_rad[i], robot.joint_max_rad[i]);
  }
  return to;
}

Posture DrawNew(const FreeFloor& floor, const RobotBodies& robot, Rng& rng) {
  Posture at = floor.Draw(rng);
  for (std::size_t i = 0; i < robot.joint_min_rad.size(); ++i) {
    // Whole turns add nothing: one is enough of a joint that can do two.
    const double lo = std::max(robot.joint_min_rad[i], -std::numbers::pi);
    const double hi = std::min(robot.joint_max_rad[i], lo + 2 * std::numbers::pi);
    at.joints_rad.push_back(rng.Uniform(lo, hi));
  }
  return at;
}

}  // namespace

CoverableSet ComputeCoverable(const Scenario& scenario, const RobotBodies& robot,
                              const CoverageProbe& probe, const CoverableConfig& config) {
  CoverableSet set;
  set.coverable.assign(probe.surface().voxels.size(), 0);
  ClearanceMeter meter(scenario.solids, robot);
  const FreeFloor floor(scenario, robot, meter);
  if (floor.empty()) {
    return set;
  }
  Rng rng(config.seed);
  RobotBodies::Pose pose;
  std::vector<Posture> fruitful;
  int since_new = 0;
  // A crowded world refuses most draws; the number of tries is bounded as well.
  const std::int64_t max_tries = 50LL * config.max_configurations;
  for (std::int64_t i = 0; i < max_tries && set.configurations < config.max_configurations; ++i) {
    const bool vary = i % 2 == 1 && !fruitful.empty();
    const Posture at =
        vary ? Vary(fruitful[rng.Index(static_cast<int>(fruitful.size()))], robot, rng)
             : DrawNew(floor, robot, rng);
    robot.forward(at.x_m, at.y_m, at.yaw_rad, at.joints_rad, pose);
    if (!floor.Reached(at) || meter.Touches(pose.X_WL)) {
      continue;
    }
    ++set.configurations;
    const int added = probe.Add(pose.p_WP, set.coverable);
    set.count += added;
    since_new = added > 0 ? 0 : since_new + 1;
    if (added > 0) {
      fruitful.push_back(at);
    }
    set.saturated = since_new >= config.saturated_after;
    if (set.saturated && set.configurations >= config.min_configurations) {
      break;
    }
  }
  return set;
}

}  // namespace pipewright::hil
