// SPDX-License-Identifier: MIT
// F7, F8 and F11: numbers that are none, QPs without an answer, covariances that are not true.
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <memory>

#include "ctrl/constraints/svfi.h"
#include "perception/primitives/soundness.h"
#include "platform/robot/shapes.h"
#include "tests/bench/faults/fault_rig.h"
#include "tests/bench/faults/rows.h"
#include "tests/ctrl/constraints/random_world.h"
#include "tests/ctrl/robot_program/config_fields.h"

namespace pipewright::bench {
namespace {

using std::chrono_literals::operator""ms;

/// A number that a running program is given.
struct Input {
  std::string name;
  std::function<double*(RobotSide& robot, Goal& goal, Surrounding& around, PoseFix& fix)> of;
};

template <typename Matrix>
void AddAll(std::vector<Input>& inputs, const std::string& name, int count,
            Matrix* (*of)(Goal&, Surrounding&, PoseFix&)) {
  for (int i = 0; i < count; ++i) {
    inputs.push_back({fmt::format("{}[{}]", name, i),
                      [of, i](RobotSide&, Goal& goal, Surrounding& around, PoseFix& fix) {
                        return of(goal, around, fix)->data() + i;
                      }});
  }
}

std::vector<Input> Inputs() {
  std::vector<Input> all;
  using S = Surrounding;
  AddAll<Vector3d>(all, "goal.p_WS", 3, [](Goal& g, S&, PoseFix&) { return &g.p_WS; });
  AddAll<Vector3d>(all, "goal.z_WS", 3, [](Goal& g, S&, PoseFix&) { return &g.z_WS; });
  AddAll<Configuration>(all, "goal.path[0]", kDof,
                        [](Goal& g, S&, PoseFix&) { return &g.path[0]; });
  AddAll<Configuration>(all, "goal.path[1]", kDof,
                        [](Goal& g, S&, PoseFix&) { return &g.path[1]; });
  AddAll<Vector3d>(all, "plane.n_W", 3,
                   [](Goal&, S& s, PoseFix&) { return &s.scene.planes[0].n_W; });
  AddAll<Mat<4, 4>>(all, "plane.covariance", 16,
                    [](Goal&, S& s, PoseFix&) { return &s.scene.planes[0].covariance; });
  AddAll<Vector3d>(all, "plane.p_WCentroid", 3,
                   [](Goal&, S& s, PoseFix&) { return &s.scene.planes[0].p_WCentroid; });
  AddAll<Vector3d>(all, "plane.e1_W", 3,
                   [](Goal&, S& s, PoseFix&) { return &s.scene.planes[0].e1_W; });
  AddAll<Vector3d>(all, "pipe.p_W", 3, [](Goal&, S& s, PoseFix&) { return &s.scene.pipes[0].p_W; });
  AddAll<Vector3d>(all, "pipe.l_W", 3, [](Goal&, S& s, PoseFix&) { return &s.scene.pipes[0].l_W; });
  AddAll<Mat<7, 7>>(all, "pipe.covariance", 49,
                    [](Goal&, S& s, PoseFix&) { return &s.scene.pipes[0].covariance; });
  AddAll<Vector3d>(all, "fix.pose", 3, [](Goal&, S&, PoseFix& f) { return &f.pose; });
  AddAll<Matrix3d>(all, "fix.information", 9, [](Goal&, S&, PoseFix& f) { return &f.information; });
  const auto add = [&all](const char* name, double* (*of)(Surrounding&)) {
    all.push_back({name, [of](RobotSide&, Goal&, Surrounding& s, PoseFix&) { return of(s); }});
  };
  add("plane.d_m", [](S& s) { return &s.scene.planes[0].d_m; });
  add("plane.extent_lo_m", [](S& s) { return &s.scene.planes[0].extent_lo_m[0]; });
  add("plane.extent_hi_m", [](S& s) { return &s.scene.planes[0].extent_hi_m[1]; });
  add("pipe.radius_m", [](S& s) { return &s.scene.pipes[0].radius_m; });
  add("pipe.extent_lo_m", [](S& s) { return &s.scene.pipes[0].extent_lo_m; });
  add("pipe.extent_hi_m", [](S& s) { return &s.scene.pipes[0].extent_hi_m; });
  return all;
}

/// A wall and a pipe 0.8 m from the robot: near enough to have rows.
Scene NearScene(const Configuration& q) {
  Scene scene;
  const Vector3d p_WB(q(0), q(1), 0.6);
  const Vector3d to_side(-std::sin(q(2)), std::cos(q(2)), 0);
  static_cast<void>(
      scene.planes.push_back(test::MakePlane(1, p_WB + 0.8 * to_side, -to_side, 0.5, 0.01, 0.003)));
  static_cast<void>(scene.pipes.push_back(
      test::MakePipe(1, p_WB - 0.8 * to_side, Vector3d::UnitZ(), 0.05, 0.5, 0.004, 0.01)));
  return scene;
}

void GiveOddInputs(FaultRig& rig, std::uint64_t n, Tally& tally) {
  const std::vector<Input> inputs = Inputs();
  const std::size_t kinds = std::size(test::kUnusable);
  const std::uint64_t all = std::min<std::uint64_t>(n, inputs.size() * kinds);
  for (std::uint64_t i = 0; i < all; ++i) {
    if (!rig.Ready(tally)) {
      return;
    }
    const Input& input = inputs[i / kinds];
    const double bad = test::kUnusable[i % kinds];
    const RobotState& state = rig.task().report().state;
    const Scene good = NearScene(state.q);
    Surrounding around{Surrounding(rig.robot().surrounding.Read())};
    around.scene = good;
    Goal goal = rig.goal();
    ++goal.id;
    PoseFix fix{.stamp = state.stamp};
    fix.pose = state.q.head<3>();
    fix.information = 1e4 * Matrix3d::Identity();
    *input.of(rig.robot(), goal, around, fix) = bad;
    rig.goal() = goal;  // the rig gives the next when this is done or its time is over
    rig.robot().goal.Write(goal);
    rig.robot().surrounding.Back() = around;
    rig.robot().surrounding.Publish();
    rig.Begin();
    rig.task().Correct(fix);
    rig.Judge({.bound = 900ms, .window = 150ms}, fmt::format("{} = {}", input.name, bad), tally);
    around.scene = Scene{};
    rig.robot().surrounding.Back() = around;
    rig.robot().surrounding.Publish();
    rig.Renew();
  }
}

}  // namespace

Tally OddNumbers(std::uint64_t n, std::uint64_t seed) {
  Tally tally;
  ControlTaskConfig good = TaskConfig({});
  good.scans_correct = true;
  std::uint64_t refused = 0;
  const auto try_config = [&](const std::string& name, const ControlTaskConfig& config) {
    FaultRig rig(seed, &config);
    bool moved = false;
    for (int i = 0; i < 1200; ++i) {
      rig.Tick();
      moved = moved || !rig.bench().AtRest();
    }
    const bool said = rig.task().status() == Status::kOutOfRange;
    refused += said ? 1 : 0;
    tally.Add(said && !moved ? Outcome::kSafeStop : Outcome::kWrong);
    if (!said || moved) {
      tally.Note(name + (said ? ": refused, and yet it moved" : ": not refused"));
    }
  };
  for (const test::Field& field : test::Fields()) {
    for (const double bad : test::kUnusable) {
      if (tally.n() < n) {
        ControlTaskConfig config = good;
        *field.of(config) = bad;
        try_config(fmt::format("{} = {}", field.name, bad), config);
      }
    }
  }
  for (const test::DurationField& field : test::DurationFields()) {
    for (const Duration bad : {Duration::max(), Duration::min(), Duration::zero()}) {
      if (tally.n() < n) {
        ControlTaskConfig config = good;
        *field.of(config) = bad;
        try_config(fmt::format("{} = {} ns", field.name, bad.count()), config);
      }
    }
  }
  const std::uint64_t configurations = tally.n();
  FaultRig rig(seed, &good);
  GiveOddInputs(rig, n - configurations, tally);
  tally.Note(fmt::format("{} of {} configurations refused at start; {} inputs of a running program",
                         refused, configurations, tally.n() - configurations));
  return tally;
}

/// The law and the envelope alone, among things that the robot is in, between or against.
Tally HardQps(std::uint64_t n, std::uint64_t seed) {
  Tally tally;
  Rng rng(seed);
  test::VoxelWorld world;
  for (int i = 0; i < 40; ++i) {
    world.AddObstacle(test::RandomIn(rng, {-0.7, -0.7, 0}, {0.7, 0.7, 1.2}));
  }
  world.Update();
  WholeBodyConfig config = TaskConfig({}).law;
  WholeBodyConfig starved = config;
  starved.svfi_rounds = 1;
  const auto law = std::make_unique<WholeBodyController>(config, TracerUf7(), TracerUf7Shapes());
  const auto hasty = std::make_unique<WholeBodyController>(starved, TracerUf7(), TracerUf7Shapes());
  const EnvelopeConfig limits = EnvelopeOf(TracerUf7(), TaskConfig({}));
  std::uint64_t infeasible = 0;
  std::uint64_t capped = 0;
  std::uint64_t out_of_reach = 0;
  constexpr int kSteps = 10;  // of one place
  Time now{std::chrono::hours(1)};
  while (tally.n() < n) {
    Scene scene;
    for (int i = rng.Index(Scene::kMaxPlanes + 1); i > 0; --i) {
      PlaneEstimate plane = test::MakePlane(
          static_cast<std::uint32_t>(i), test::RandomIn(rng, {-1, -1, 0}, {1, 1, 1.5}),
          test::RandomDirection(rng), rng.Uniform(0.1, 1), 0.02, 0.01);
      if (!scene.planes.empty() &&
          rng.Index(3) == 0) {  // the same again, or its other side: degenerate rows
        plane = scene.planes[0];
        plane.n_W = rng.Index(2) == 0 ? plane.n_W : -plane.n_W;
        plane.d_m = plane.n_W.dot(plane.p_WCentroid);
      }
      static_cast<void>(scene.planes.push_back(plane));
    }
    for (int i = rng.Index(Scene::kMaxPipes + 1); i > 0; --i) {
      static_cast<void>(scene.pipes.push_back(
          test::MakePipe(static_cast<std::uint32_t>(i),
                         test::RandomIn(rng, {-1, -1, 0}, {1, 1, 1.5}), test::RandomDirection(rng),
                         rng.Uniform(0.02, 0.2), 0.5, rng.Uniform(0, 0.05), rng.Uniform(0, 0.1))));
    }
    Goal goal;
    goal.id = static_cast<std::uint32_t>(tally.n() + 1);
    goal.p_WS = test::RandomIn(rng, {-2, -2, 0}, {2, 2, 2});
    goal.z_WS = test::RandomDirection(rng);
    RobotState state;
    state.q = test::RandomConfiguration(rng);
    state.valid = true;
    Envelope envelope(limits);
    WholeBodyController& chosen = rng.Index(2) == 0 ? *law : *hasty;
    Controls before = Controls::Zero();
    for (int step = 0; step < kSteps && tally.n() < n; ++step) {
      now += 10ms;
      state.stamp = now;
      state.u = before;
      ControlOutput output =
          chosen.Step({.state = state, .scene = scene, .field = world.field(), .goal = goal}, now);
      const Controls u = envelope.Step(output.u, state, now).u;
      chosen.Sent(u, output.stats);
      infeasible += output.stats.qp.status == QpStatus::kInfeasible ? 1 : 0;
      capped +=
          output.stats.qp.status == QpStatus::kCapped || output.stats.qp.fallbacks > 0 ? 1 : 0;
      out_of_reach += output.stats.qp.out_of_reach ? 1 : 0;
      // By hand: finite, within speed, and no faster away from zero than a_max allows.
      bool lawful = u.allFinite();
      for (int i = 0; i < kControls && lawful; ++i) {
        const double growth =
            u(i) * before(i) < 0 ? std::abs(u(i)) : std::abs(u(i)) - std::abs(before(i));
        lawful =
            std::abs(u(i)) <= kSpeedMax[i] + 1e-9 && growth <= kAccelerationMax[i] * 0.01 + 1e-9;
      }
      tally.Add(!lawful ? Outcome::kWrong : u.isZero(0) ? Outcome::kSafeStop : Outcome::kMasked);
      if (!lawful) {
        tally.Note(fmt::format("unlawful at case {}", tally.n()));
      }
      before = u;
      state.q(0) += 0.01 * u(0) * std::cos(state.q(2));
      state.q(1) += 0.01 * u(0) * std::sin(state.q(2));
      state.q(2) += 0.01 * u(1);
      state.q.tail<kArmJoints>() += 0.01 * u.tail<kArmJoints>();
    }
  }
  tally.Note(
      fmt::format("{} infeasible, {} at a cap of rounds or iterations, {} where no u that can "
                  "be reached keeps every row",
                  infeasible, capped, out_of_reach));
  return tally;
}

Tally WrongCovariances(std::uint64_t n, std::uint64_t seed) {
  Tally tally;
  Rng rng(seed);
  const double z = *ChanceQuantile(0.7);
  std::uint64_t violated = 0;
  std::uint64_t violated_true = 0;
  std::uint64_t understated = 0;
  for (std::uint64_t i = 0; i < n; ++i) {
    const Vector3d p = test::RandomIn(rng, {-1, -1, 0}, {1, 1, 1.5});
    const Vector3d n_W = test::RandomDirection(rng);
    PlaneEstimate plane = test::MakePlane(1, p, n_W, 0.5, 0.02, 0.01);
    PipeEstimate pipe = test::MakePipe(1, p, n_W, 0.05, 0.5, 0.005, 0.01);
    switch (i % 3) {
      case 0:
        plane.covariance.setZero();
        pipe.covariance.setZero();
        break;
      case 1:  // one direction's variance is negative, by as little as a tenth of the others'
        plane.covariance -= rng.Uniform(1.1, 3) * 1e-4 * plane.e1_W.homogeneous() *
                                plane.e1_W.homogeneous().transpose() +
                            4e-4 * Mat<4, 4>::Identity();
        pipe.covariance.topLeftCorner<3, 3>() -=
            rng.Uniform(1.1, 3) * 25e-6 * n_W.unitOrthogonal() * n_W.unitOrthogonal().transpose();
        break;
      default: {
        // Understated tenfold, it is taken: nothing in it is wrong. A point that leans on its row
        // by that covariance, and the true plane drawn from the true one.
        ++understated;
        const Mat<4, 4> truth = plane.covariance;
        plane.covariance /= 10;
        const bool taken = Sound(plane);
        tally.Add(taken ? Outcome::kMasked : Outcome::kWrong);
        const Vector3d t = p + rng.Uniform(0.1, 0.6) * n_W + rng.Uniform(-0.3, 0.3) * plane.e1_W;
        const Vector3d v = test::RandomDirection(rng) * rng.Uniform(0, 0.4);
        constexpr double kEta = 1;
        const auto rate = [&](const Vector3d& normal, double d_m) {
          return normal.dot(v) + kEta * (normal.dot(t) - d_m);
        };
        const double turn1 = 0.02 * rng.Normal();
        const double turn2 = 0.02 * rng.Normal();
        const Vector3d dn = turn1 * plane.e1_W + turn2 * plane.e2_W;
        const double dd = dn.dot(p) + 0.01 * rng.Normal();
        const double change = rate(n_W + dn, plane.d_m + dd) - rate(n_W, plane.d_m);
        violated += change < -z * PlaneCone(plane, t, kEta).Sigma(v) ? 1 : 0;
        plane.covariance = truth;
        violated_true += change < -z * PlaneCone(plane, t, kEta).Sigma(v) ? 1 : 0;
        continue;
      }
    }
    const bool taken = Sound(plane) || Sound(pipe);
    tally.Add(taken ? Outcome::kWrong : Outcome::kSafeStop);
    if (taken) {
      tally.Note(i % 3 == 0 ? "zero was taken" : "one that is not positive semidefinite was taken");
    }
  }
  tally.Note(fmt::format(
      "at alpha = 0.7, of points that lean on their row: {:.3f} violated with the covariance 10x "
      "understated, {:.3f} with the true one (of {})",
      static_cast<double>(violated) / static_cast<double>(std::max<std::uint64_t>(1, understated)),
      static_cast<double>(violated_true) /
          static_cast<double>(std::max<std::uint64_t>(1, understated)),
      understated));
  return tally;
}

}  // namespace pipewright::bench
