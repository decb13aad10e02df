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

int BasePoint() { return TracerUf7Shapes().spheres.size() + TracerUf7Shapes().discs.size(); }

double SafeOf(Primitive primitive, int point) {
  const ConstraintConfig c;
  if (point == BasePoint()) {
    return c.d_safe_base_plane_m;
  }
  const double table = primitive == Primitive::kPlane ? c.d_safe_plane_m : c.d_safe_pipe_m;
  return std::max(table, TracerUf7Shapes().spheres[point].r_m + c.margin_m);
}

/// Whether the base's centre has a row, which a plane's slope decides.
bool BaseCounts(const Surface& estimate) {
  return estimate.kind == Primitive::kPlane && std::abs(estimate.axis.z()) < kNearVertical;
}

/// The robot point with least to spare before a surface, and how much that is.
struct Nearest {
  int point = 0;
  double spare_m = 1e9;
};
Nearest NearestPoint(const Configuration& q, const Surface& surface, bool with_base,
                     double inflation_m) {
  const Scene scene = surface.ToScene();
  Nearest nearest;
  for (int i = 0; i <= BasePoint(); ++i) {
    const bool counts = i == BasePoint() ? with_base : i < TracerUf7Shapes().spheres.size();
    if (!counts) {
      continue;
    }
    const Vector3d t = PointAt(q, i);
    const double d =
        surface.kind == Primitive::kPlane
            ? PointToPlane(t, scene.planes[0]).d_m
            : PointToPipeAxis(t, scene.pipes[0], inflation_m).to_axis.d_m - surface.radius_m;
    const double spare_m = d - SafeOf(surface.kind, i);
    if (spare_m < nearest.spare_m) {
      nearest = {i, spare_m};
    }
  }
  return nearest;
}

double StandingSigma(const Surface& surface, const Vector3d& t) {
  const Scene scene = surface.ToScene();
  const VelocityCone cone =
      surface.kind == Primitive::kPlane
          ? PlaneCone(scene.planes[0], t, kEta_1ps)
          : PipeCone(scene.pipes[0], PointToPipeAxis(t, scene.pipes[0], kInflation_m), kEta_1ps);
  return cone.Sigma(Vector3d::Zero()) / kEta_1ps;
}

Vector3d Across(Rng& rng, const Vector3d& axis) {
  const Vector3d v = test::RandomDirection(rng);
  return (v - axis * axis.dot(v)).normalized();
}

/// A surface across `ahead`, so near that the robot's nearest point has little to spare beyond
/// what alpha asks of it standing still.
Surface Place(Rng& rng, const Cell& cell, const Configuration& q, const Vector3d& ahead) {
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
  }
  const Kinematics<kArmJoints> k(TracerUf7(), q);
  const double off_m = cell.primitive == Primitive::kPipeEnd ? 0.0 : rng.Uniform(0, 0.5);
  s.p = k.p_WS() + ahead + off_m * side;
  const double z = *ChanceQuantile(cell.alpha);
  const double more_m = rng.Uniform(0.005, 0.06);
  for (int i = 0; i < 8; ++i) {  // which point is nearest changes on the way
    const Nearest nearest = NearestPoint(q, s, BaseCounts(s), kInflation_m);
    const double gap_m = z * StandingSigma(s, PointAt(q, nearest.point)) + more_m;
    s.p += (gap_m - nearest.spare_m) * ahead;
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

Scene Surface::ToScene() const {
  Scene scene;
  if (kind == Primitive::kPlane) {
    (void)scene.planes.push_back(test::MakePlane(1, p, axis, half_m, sigma_rad, sigma_m));
  } else {
    (void)scene.pipes.push_back(test::MakePipe(1, p, axis, radius_m, half_m, sigma_m, sigma_rad));
  }
  return scene;
}

Surface Surface::Draw(Rng& rng) const {
  const Vector3d a = axis.unitOrthogonal();
  const Vector3d b = axis.cross(a);
  Surface drawn = *this;
  const Vector3d tilt = sigma_rad * (rng.Normal() * a + rng.Normal() * b);
  const double angle = tilt.norm();
  drawn.axis = angle > 0 ? Vector3d(std::cos(angle) * axis + std::sin(angle) / angle * tilt) : axis;
  if (kind == Primitive::kPlane) {
    drawn.p += sigma_m * rng.Normal() * drawn.axis;
  } else {
    drawn.p += sigma_m * (rng.Normal() * a + rng.Normal() * b);
    drawn.radius_m += sigma_m / 2 * rng.Normal();
  }
  return drawn;
}

WholeBodyConfig ConfigOf(const Cell& cell) {
  WholeBodyConfig config;
  config.constraints.alpha = cell.alpha;
  config.constraints.svfi = cell.mode;
  config.constraints.price[static_cast<int>(RowKind::kPipe)] = 0;  // a soft row promises nothing
  return config;
}

Vector3d PointAt(const Configuration& q, int point) {
  const Kinematics<kArmJoints> k(TracerUf7(), q);
  if (point == BasePoint()) {
    return k.Point(0, {0, 0, 0.1});
  }
  const BodySphere& sphere = TracerUf7Shapes().spheres[point];
  return k.Point(sphere.body, sphere.p_L);
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

/// Sorts a cycle into the result: `before` is the controller as the cycle began, `set` what it
/// made of it.
void Record(const Cell& cell, const Loop& loop, std::unique_ptr<WholeBodyController> before,
            const ConstraintSet& set, const Controls& u, int keep, Rng& pick, LoopResult& result) {
  const ChanceRow* row = MostLeanedOn(cell, set, u, loop.state.u);
  if (row == nullptr) {
    return;
  }
  const int point = (row->key >> 16) & 0x3FF;
  const Vector3d t = PointAt(loop.state.q, point);
  const bool at_end = cell.primitive != Primitive::kPlane &&
                      PointToPipeAxis(t, loop.estimate.ToScene().pipes[0], kInflation_m).at_end;
  if (at_end != (cell.primitive == Primitive::kPipeEnd)) {
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
                    point,
                    t,
                    row->J * u,
                    SafeOf(cell.primitive, point),
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
  static const test::VoxelWorld world;
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
    const Kinematics<kArmJoints> start(TracerUf7(), state.q);
    const Vector3d ahead = (Vector3d::UnitX() + 0.8 * test::RandomDirection(rng)).normalized();
    loop.estimate = Place(rng, cell, state.q, ahead);
    loop.truth = loop.estimate.Draw(rng);
    const Scene scene = loop.estimate.ToScene();
    double least_m = 0;
    for (int cycle = 0; cycle < kGoals * kCyclesPerGoal; ++cycle) {
      if (cycle % kCyclesPerGoal == 0) {  // from standing or sliding: u must change
        ++loop.goal.id;
        loop.goal.p_WS = start.p_WS() + rng.Uniform(0.1, 0.4) * ahead +
                         rng.Uniform(0.2, 0.6) * Across(rng, ahead);
        loop.goal.z_WS = start.z_WS();
      }
      auto before = std::make_unique<WholeBodyController>(*controller);
      const Controls u = controller->Step({state, scene, world.field(), loop.goal}, loop.now).u;
      Record(cell, loop, std::move(before), controller->constraints(), u, keep, pick, result);
      state.q = Advance(state.q, u, ToSeconds(kPeriod));
      state.u = u;
      loop.now += kPeriod;
      state.stamp = loop.now;
      // What was not seen of a true pipe is not there: no inflation.
      least_m = std::min(least_m,
                         NearestPoint(state.q, loop.truth, BaseCounts(loop.estimate), 0).spare_m);
    }
    ++result.episodes;
    result.episodes_kept += least_m >= 0 ? 1 : 0;
    result.penetration_mm = std::max(result.penetration_mm, -1000 * least_m);
  }
  return result;
}

}  // namespace pipewright::bench
