// SPDX-License-Identifier: MIT
#include "tests/plan/cfnbv/toy_cell.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "plan/motion/edge.h"
#include "platform/robot/kinematics.h"
#include "platform/robot/shapes.h"
#include "platform/robot/uf7.h"

namespace pipewright::test {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();
constexpr double kCell_m = 1.5;
constexpr double kRangeMin_m = 0.168;
constexpr double kRangeMax_m = 6.0;
constexpr double kProbeRadius_m = 0.4;

/// First crossing of the wall {p[axis] = at}, a square of the cell's size.
double CastWall(const Vector3d& o, const Vector3d& d, int axis, double at) {
  const double t = (at - o[axis]) / d[axis];
  const Vector3d p = o + t * d;
  for (int i = 0; i < 3; ++i) {
    if (i != axis && !(p[i] >= 0 && p[i] <= kCell_m)) {
      return kNone;
    }
  }
  return t > 0 ? t : kNone;
}

/// Where a ray from inside meets the hall about the cell.
double CastHall(const Vector3d& o, const Vector3d& d) {
  const Vector3d lo(-2, -2, 0);
  const Vector3d hi(3.5, 3.5, 3);
  double t = kNone;
  for (int i = 0; i < 3; ++i) {
    t = std::min(t, ((d[i] > 0 ? hi[i] : lo[i]) - o[i]) / d[i]);
  }
  return t;
}

double CastPipe(const Vector3d& o, const Vector3d& d, const ToyPipe& pipe) {
  const auto across = [&](const Vector3d& v) { return Vector3d(v - v.dot(pipe.l_W) * pipe.l_W); };
  const Vector3d m = across(o - pipe.p_W);
  const Vector3d n = across(d);
  const double a = n.squaredNorm();
  const double b = m.dot(n);
  const double c = m.squaredNorm() - pipe.radius_m * pipe.radius_m;
  const double root = b * b - a * c;
  if (root < 0 || a < 1e-12) {
    return kNone;
  }
  const double t = (-b - std::sqrt(root)) / a;
  const double along = (o + t * d - pipe.p_W).dot(pipe.l_W);
  return t > 0 && 0 <= along && along <= pipe.length_m ? t : kNone;
}

}  // namespace

MapConfig ToyCell::Config() {
  MapConfig config;
  config.lo = {-8, -8, -2};
  config.hi = {37, 37, 37};
  config.workspace_lo = {2, 2, 2};
  config.workspace_hi = {27, 27, 27};
  config.brick_capacity = BricksOfBox(config);
  return config;
}

std::vector<ToyPipe> ToyCell::ThreePipes() {
  return {{{1.20, 1.15, 0}, Vector3d::UnitZ(), 1.5, 0.05},
          {{1.20, 0, 0.9}, Vector3d::UnitY(), 1.15, 0.04},
          {{0, 0.2, 0.55}, Vector3d::UnitX(), 1.5, 0.05}};
}

Configuration ToyCell::StartPose() {
  Configuration q;
  q << 0.35, 0.75, 0, std::numbers::pi, -0.9, 0, 0.5, 0, -0.4, 0;
  return q;
}

ToyCell::ToyCell(std::vector<ToyPipe> pipes)
    : map(Config()), field(Config()), pipes_(std::move(pipes)), estimate_(pipes_.size(), -1) {
  covered_.assign(static_cast<std::size_t>(map.voxel_count()), 0);
  for (const ToyPipe& pipe : pipes_) {
    const Vector3d e1 = pipe.l_W.unitOrthogonal();
    const Vector3d e2 = pipe.l_W.cross(e1);
    for (double along = 0; along < pipe.length_m; along += 0.0125) {
      for (int i = 0; i < 40; ++i) {
        const double angle = 2 * std::numbers::pi * i / 40;
        const Vector3d p_W = pipe.p_W + along * pipe.l_W +
                             pipe.radius_m * (std::cos(angle) * e1 + std::sin(angle) * e2);
        if (map.InWorkspace(map.VoxelOf(p_W))) {
          surface_.push_back(p_W);
          surface_voxel_.push_back(map.IndexOf(map.VoxelOf(p_W)));
        }
      }
    }
  }
}

double ToyCell::Cast(const Vector3d& origin, const Vector3d& direction, int* pipe) const {
  double t = std::min({CastHall(origin, direction), CastWall(origin, direction, 0, kCell_m),
                       CastWall(origin, direction, 1, 0), CastWall(origin, direction, 1, kCell_m)});
  for (std::size_t i = 0; i < pipes_.size(); ++i) {
    const double t_pipe = CastPipe(origin, direction, pipes_[i]);
    if (t_pipe < t && pipe != nullptr) {
      *pipe = static_cast<int>(i);
    }
    t = std::min(t, t_pipe);
  }
  return t;
}

/// An estimate without error, as far as the pipe was seen.
void ToyCell::See(int pipe, const Vector3d& p_W) {
  const ToyPipe& truth = pipes_[pipe];
  const double along_m = (p_W - truth.p_W).dot(truth.l_W);
  if (estimate_[pipe] < 0) {
    PipeEstimate estimate;
    estimate.p_W = truth.p_W;
    estimate.l_W = truth.l_W;
    estimate.radius_m = truth.radius_m;
    estimate.extent_lo_m = along_m;
    estimate.extent_hi_m = along_m;
    estimate_[pipe] = scene.pipes.push_back(estimate) ? scene.pipes.size() - 1 : -1;
  }
  PipeEstimate& estimate = scene.pipes[estimate_[pipe]];
  ++estimate.frames_seen;
  estimate.extent_lo_m = std::min(estimate.extent_lo_m, along_m);
  estimate.extent_hi_m = std::max(estimate.extent_hi_m, along_m);
}

void ToyCell::Sweep(const Configuration& q, double inflate_m) {
  const Kinematics<kArmJoints> robot(TracerUf7(), q);
  for (const BodySphere& s : TracerUf7Shapes().spheres) {
    map.MarkSweptSphere(robot.Point(s.body, s.p_L), s.r_m + inflate_m);
  }
  const TracerModel& base = TracerUf7().base;
  for (double x = -base.length_m / 2; x <= base.length_m / 2 + 1e-9; x += 0.05) {
    for (double y = -base.width_m / 2; y <= base.width_m / 2 + 1e-9; y += 0.05) {
      for (double z = 0; z <= 0.3; z += 0.05) {
        map.MarkSweptSphere(robot.X_WL(0) * Vector3d(x, y, z), 0.03 + inflate_m);
      }
    }
  }
}

void ToyCell::Begin(const Configuration& q, double clearance_m) {
  Sweep(q, clearance_m);
  Look(q);
}

void ToyCell::Look(const Configuration& q) {
  constexpr int kColumns = 72;
  constexpr int kRows = 44;
  const Kinematics<kArmJoints> robot(TracerUf7(), q);
  const Isometry3d X_WS = robot.X_WS();
  const double x_max = std::tan(87 * std::numbers::pi / 360);
  const double y_max = std::tan(58 * std::numbers::pi / 360);
  std::vector<Vector3f> points;
  for (int i = 0; i < kColumns * kRows; ++i) {
    const double x = x_max * (2 * ((i % kColumns) + 0.5) / kColumns - 1);
    const double y = y_max * (2 * ((i / kColumns) + 0.5) / kRows - 1);
    const Vector3d direction = X_WS.linear() * Vector3d(x, y, 1);  // t is then the depth
    int pipe = -1;
    const double depth = Cast(X_WS.translation(), direction, &pipe);
    const Vector3d p_W = X_WS.translation() + depth * direction;
    if (depth >= kRangeMin_m && depth <= kRangeMax_m) {
      points.push_back(p_W.cast<float>());
    }
    if (depth >= kRangeMin_m && depth <= kRangeMax_m && pipe >= 0) {
      See(pipe, p_W);
    }
  }
  map.InsertScan(points.data(), static_cast<int>(points.size()),
                 Vector3d(X_WS.translation()).cast<float>(), -1);
  Sweep(q, 0);
  map.MarkCovered(robot.p_WP(), kProbeRadius_m);
  CoverTruth(robot.p_WP());
  field.Update(map);
}

void ToyCell::CoverTruth(const Vector3d& p_WP) {
  for (std::size_t i = 0; i < surface_.size(); ++i) {
    const Vector3d way = surface_[i] - p_WP;
    if (covered_[surface_voxel_[i]] == 0 && way.norm() <= kProbeRadius_m &&
        Cast(p_WP, way) > 1 - 1e-6) {
      covered_[surface_voxel_[i]] = 1;
    }
  }
}

double ToyCell::Follow(const Goal& goal, Configuration& q,
                       const std::function<void(const Configuration&)>& visit) {
  double seconds = 0;
  for (int i = 0; i + 1 < goal.path.size(); ++i) {
    const Edge edge(goal.path[i], goal.path[i + 1], SpeedsOf(TracerUf7()));
    const int steps = std::max(1, static_cast<int>(edge.duration_s() / 0.1));
    for (int k = 1; k <= steps; ++k) {
      q = edge.At(static_cast<double>(k) / steps);
      Look(q);
      if (visit) {
        visit(q);
      }
    }
    seconds += edge.duration_s();
  }
  return seconds;
}

std::vector<int> ToyCell::Missed() const {
  std::set<int> missed;
  for (const int voxel : surface_voxel_) {
    if (covered_[voxel] == 0) {
      missed.insert(voxel);
    }
  }
  return {missed.begin(), missed.end()};
}

double ToyCell::TruthCoverage() const {
  const std::set<int> all(surface_voxel_.begin(), surface_voxel_.end());
  return 1 - static_cast<double>(Missed().size()) / static_cast<double>(all.size());
}

}  // namespace pipewright::test
