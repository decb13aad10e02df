// SPDX-License-Identifier: MIT
#include "tests/bench/svfi_loop.h"

#include <algorithm>

#include "platform/robot/state_history.h"
#include "tests/ctrl/constraints/random_world.h"

namespace pipewright::bench {
namespace {

constexpr Duration kPeriod = std::chrono::milliseconds(10);
constexpr int kGoals = 3;
constexpr int kCyclesPerGoal = 100;
constexpr double kLeaned_mps = 1e-5;
constexpr double kNearVertical = ConstraintConfig{}.near_vertical_nz;

/// Whether the base's centre has a row, which a plane's slope decides.
bool BaseCounts(const Surface& estimate) {
  return estimate.kind == Primitive::kPlane && std::abs(estimate.axis.z()) < kNearVertical;
}

double DistanceTo(const Surface& surface, const Vector3d& t, double inflation_m) {
  const Scene scene = surface.ToScene();
  switch (surface.kind) {
    case Primitive::kPlane:
      return PointToPlane(t, scene.planes[0]).d_m;
    case Primitive::kPipe:
    case Primitive::kPipeEnd:
      return PointToPipeAxis(t, scene.pipes[0], inflation_m).to_axis.d_m - surface.radius_m;
    case Primitive::kVoxel:
      return ((t - surface.p).head<2>().cwiseAbs().array() - surface.half_m).max(0).matrix().norm();
  }
  return 0;
}

/// Whether a robot point has a row before a surface.
bool Counts(const Surface& estimate, int point) {
  const int spheres = TracerUf7Shapes().spheres.size();
  return point < spheres || (estimate.kind == Primitive::kVoxel && point < BasePoint()) ||
         (point == BasePoint() && BaseCounts(estimate));
}

/// The robot point with least to spare before a surface, and how much that is.
struct Nearest {
  int point = 0;
  double spare_m = 1e9;
};
Nearest NearestPoint(const Configuration& q, const Surface& surface, const Surface& estimate,
                     double inflation_m) {
  Nearest nearest;
  for (int i = 0; i <= BasePoint(); ++i) {
    if (!Counts(estimate, i)) {
      continue;
    }
    const double spare_m =
        DistanceTo(surface, PointAt(q, i), inflation_m) - SafeOf(surface.kind, i);
    if (spare_m < nearest.spare_m) {
      nearest = {i, spare_m};
    }
  }
  return nearest;
}

double StandingSigma(const Surface& surface, const Vector3d& t) {
  const Scene scene = surface.ToScene();
  const double eta = EtaOf(surface.kind);
  switch (surface.kind) {
    case Primitive::kPlane:
      return PlaneCone(scene.planes[0], t, eta).Sigma(Vector3d::Zero()) / eta;
    case Primitive::kPipe:
    case Primitive::kPipeEnd:
      return PipeCone(scene.pipes[0], PointToPipeAxis(t, scene.pipes[0], kInflation_m), eta)
                 .Sigma(Vector3d::Zero()) /
             eta;
    case Primitive::kVoxel:
      return surface.sigma_m;
  }
  return 0;
}

Vector3d Across(Rng& rng, const Vector3d& axis) {
  const Vector3d v = test::RandomDirection(rng);
  return (v - axis * axis.dot(v)).normalized();
}

/// A post of 1 to 4 voxels ahead of where the robot is put.
Surface PlacePost(Rng& rng, const Vector3d& ahead, Configuration& q) {
  Surface s;
  s.kind = Primitive::kVoxel;
  s.half_m = kVoxel_m / 2 * (1 + rng.Index(kPosts));
  s.p = {kPostAt_m + s.half_m, s.half_m, 0};
  s.sigma_m = ConstraintConfig{}.voxel_noise_m;
  const Kinematics<kArmJoints> k(TracerUf7(), q);
  q.head<2>() += (s.p - k.p_WS() - 0.4 * ahead).head<2>();
  return s;
}

/// A surface across `ahead`, so near that the robot's nearest point has little to spare beyond
/// what alpha asks of it standing still. For a post it is the robot that is moved.
Surface PlaceSurface(Rng& rng, const Cell& cell, const Vector3d& ahead, Configuration& q) {
  Surface s;
  s.kind = cell.primitive;
  s.sigma_m = rng.Uniform(0.002, 0.01);
  s.sigma_rad = rng.Uniform(0.01, 0.06);
  const Vector3d side = Across(rng, ahead);
  switch (cell.primitive) {
    case Primitive::kPlane:
      s.axis = -ahead;
      break;
    case Primitive::kPipe:
      s.axis = side;
      s.radius_m = rng.Uniform(0.03, 0.1);
      break;
    case Primitive::kPipeEnd:
      s.axis = (ahead + 0.3 * side).normalized();
      s.half_m = 0.3;
      s.radius_m = rng.Uniform(0.1, 0.15);  // so wide that the end is met before the side
      break;
    case Primitive::kVoxel:
      s = PlacePost(rng, ahead, q);
      break;
  }
  const bool post = cell.primitive == Primitive::kVoxel;
  if (!post) {
    const Kinematics<kArmJoints> k(TracerUf7(), q);
    const double off_m = cell.primitive == Primitive::kPipeEnd ? 0.0 : rng.Uniform(0, 0.5);
    s.p = k.p_WS() + ahead + off_m * side;
  }
  const double z = *ChanceQuantile(cell.alpha);
  const double more_m = rng.Uniform(0.005, 0.06);
  for (int i = 0; i < 8; ++i) {  // which point is nearest changes on the way
    const Nearest nearest = NearestPoint(q, s, s, kInflation_m);
    const double gap_m = z * StandingSigma(s, PointAt(q, nearest.point)) + more_m;
    if (post) {
      q.head<2>() -= (gap_m - nearest.spare_m) * ahead.head<2>();
    } else {
      s.p += (gap_m - nearest.spare_m) * ahead;
    }
  }
  return s;
}

double OwnExcess(const Cell& cell, const ChanceRow& row, const ConstraintSet& set,
                 const Controls& u, const Controls& u_before) {
  if (cell.mode == SvfiMode::kExact) {
    return ChanceExcess(row, u, set.z);
  }
  const Row linear = cell.mode == SvfiMode::kPreviousVelocity
                         ? FrozenRow(row, u_before, set.z)
                         : WorstCaseRow(row, set.lb, set.ub, set.z);
  return linear.a.dot(u) - linear.hi;
}

/// The row that u is stopped by most, as the mode poses it; null: by none.
const ChanceRow* MostLeanedOn(const Cell& cell, const ConstraintSet& set, const Controls& u,
                              const Controls& u_before) {
  const ChanceRow* most = nullptr;
  double excess = -kLeaned_mps;
  for (const ChanceRow& row : set.chance) {
    const double own = OwnExcess(cell, row, set, u, u_before);
    if (own >= excess) {
      most = &row;
      excess = own;
    }
  }
  return most;
}

void Count(const ChanceRow& row, double z, const Controls& u, Leaned& leaned) {
  const double sigma = row.cone.Sigma(row.J * u);
  const double spare = row.b - row.a.dot(u);
  ++leaned.cycles;
  leaned.margin_sum += spare / sigma - z;
  leaned.margin_min = std::min(leaned.margin_min, spare / sigma - z);
  leaned.row_margin_min = std::min(leaned.row_margin_min, (row.limit - row.a.dot(u)) / sigma - z);
  leaned.slack_sum_mps += spare - z * sigma;
}

}  // namespace

WholeBodyConfig ConfigOf(const Cell& cell) {
  WholeBodyConfig config;
  config.constraints.alpha = cell.alpha;
  config.constraints.svfi = cell.mode;
  config.constraints.joint_risk = cell.joint;
  config.constraints.price[static_cast<int>(RowKind::kPipe)] = 0;  // a soft row promises nothing
  return config;
}

namespace {

/// What a closed loop is about, and how far it has come.
struct Loop {
  Surface estimate;
  Surface truth;
  RobotState state;
  Goal goal;
  Time now{};
};

int PointOf(const ChanceRow& row) { return (row.key >> 16) & 0x3FF; }

/// Whether the row is of what the cell is about: a pipe's side or end, the voxel that is nearest
/// now (not where the point is heading).
bool IsOfItsPrimitive(const Cell& cell, const Loop& loop, const ChanceRow& row) {
  if (cell.primitive == Primitive::kVoxel) {
    return (row.key & 0xFFFF) == 0;
  }
  if (cell.primitive == Primitive::kPlane) {
    return true;
  }
  const Vector3d t = PointAt(loop.state.q, PointOf(row));
  const bool at_end = PointToPipeAxis(t, loop.estimate.ToScene().pipes[0], kInflation_m).at_end;
  return at_end == (cell.primitive == Primitive::kPipeEnd);
}

/// Of one row, or of all that share the risk.
std::vector<int> PointsOf(const Cell& cell, const ConstraintSet& set, const ChanceRow& leaned_on) {
  if (!cell.joint) {
    return {PointOf(leaned_on)};
  }
  std::vector<int> points;
  for (const ChanceRow& row : set.chance) {
    if (std::find(points.begin(), points.end(), PointOf(row)) == points.end()) {
      points.push_back(PointOf(row));
    }
  }
  return points;
}

/// Sorts a cycle into the result: `before` is the controller as the cycle began, `set` what it
/// made of it.
void Record(const Cell& cell, const Loop& loop, std::unique_ptr<WholeBodyController> before,
            const ConstraintSet& set, const Controls& u, int keep, Rng& pick, LoopResult& result) {
  const ChanceRow* row = MostLeanedOn(cell, set, u, loop.state.u);
  if (row == nullptr) {
    return;
  }
  if (!IsOfItsPrimitive(cell, loop, *row)) {
    return;
  }
  if (row->b < set.z * std::sqrt(std::max(row->cone.c, 0.0))) {
    ++result.clamped;
    return;
  }
  const double least = std::min(result.rising.margin_min, result.rest.margin_min);
  const bool rising = row->cone.Sigma(row->J * u) > 1.01 * row->cone.Sigma(row->J * loop.state.u);
  Leaned& leaned = rising ? result.rising : result.rest;
  Count(*row, set.z, u, leaned);
  const auto instance = [&](std::unique_ptr<WholeBodyController> kept) {
    return Instance{std::move(kept),
                    loop.state,
                    loop.goal,
                    loop.estimate,
                    loop.now,
                    cell.unsure,
                    PointsOf(cell, set, *row),
                    u,
                    row->b - row->limit};
  };
  if (leaned.margin_min < least) {
    result.worst = instance(nullptr);
  }
  const int size = static_cast<int>(leaned.sample.size());
  const int slot = size < keep ? size : pick.Index(static_cast<int>(leaned.cycles));
  if (slot < keep) {
    leaned.sample.resize(static_cast<std::size_t>(std::max(size, slot + 1)));
    leaned.sample[static_cast<std::size_t>(slot)] = instance(std::move(before));
  }
}

}  // namespace

LoopResult RunLoops(const Cell& cell, int episodes, int keep, std::uint64_t seed) {
  LoopResult result;
  Rng pick(seed, 1);
  for (int episode = 0; episode < episodes; ++episode) {
    Rng rng(seed, 1000 + static_cast<std::uint64_t>(episode));
    auto controller =
        std::make_unique<WholeBodyController>(ConfigOf(cell), TracerUf7(), TracerUf7Shapes());
    Loop loop;
    RobotState& state = loop.state;
    state.valid = true;
    state.q = test::HomeConfiguration();
    for (int j = 3; j < kDof; ++j) {
      state.q(j) += rng.Uniform(-0.3, 0.3);
    }
    Vector3d ahead = Vector3d::UnitX() + 0.8 * test::RandomDirection(rng);
    ahead.z() *= cell.primitive == Primitive::kVoxel ? 0 : 1;  // posts are as high as the map
    ahead.normalize();
    loop.estimate = PlaceSurface(rng, cell, ahead, state.q);
    loop.truth = loop.estimate.Draw(rng);
    const Kinematics<kArmJoints> start(TracerUf7(), state.q);
    const Scene scene = loop.estimate.ToScene();
    const StateCovariance* covariance_q = cell.unsure ? &UnsureState() : nullptr;
    const Configuration off =
        cell.unsure ? DrawState(Configuration::Zero(), rng) : Configuration(Configuration::Zero());
    double least_m = 0;
    for (int cycle = 0; cycle < kGoals * kCyclesPerGoal; ++cycle) {
      if (cycle % kCyclesPerGoal == 0) {  // from standing or sliding: u must change
        ++loop.goal.id;
        loop.goal.p_WS = start.p_WS() + rng.Uniform(0.1, 0.4) * ahead +
                         rng.Uniform(0.2, 0.6) * Across(rng, ahead);
        loop.goal.z_WS = start.z_WS();
      }
      auto before = std::make_unique<WholeBodyController>(*controller);
      const ControlInput input{state, scene, loop.estimate.Field(), loop.goal, covariance_q};
      const Controls u = controller->Step(input, loop.now).u;
      Record(cell, loop, std::move(before), controller->constraints(), u, keep, pick, result);
      state.q = Advance(state.q, u, ToSeconds(kPeriod));
      state.u = u;
      loop.now += kPeriod;
      state.stamp = loop.now;
      // What was not seen of a true pipe is not there: no inflation.
      least_m =
          std::min(least_m, NearestPoint(state.q + off, loop.truth, loop.estimate, 0).spare_m);
    }
    ++result.episodes;
    result.episodes_kept += least_m >= 0 ? 1 : 0;
    result.penetration_mm = std::max(result.penetration_mm, -1000 * least_m);
  }
  return result;
}

}  // namespace pipewright::bench
