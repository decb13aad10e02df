// SPDX-License-Identifier: MIT
// What the robot's kinematics, a collision check, a reach and a plan cost, in a cell with three
// pipes. Compare only figures of one run on one machine.
#include <benchmark/benchmark.h>

#include <vector>

#include "plan/motion/inverse_kinematics.h"
#include "plan/motion/motion_planner.h"
#include "tests/plan/motion/cell.h"

namespace pipewright {
namespace {

test::Cell& CellOfThreePipes() {
  static test::Cell& cell = []() -> test::Cell& {
    static test::Cell made;
    made.AddThreePipes();
    return made;
  }();
  return cell;
}

std::vector<Configuration> Configurations(bool only_free) {
  const CollisionChecker checker(CellOfThreePipes().around());
  Rng rng(91);
  std::vector<Configuration> made;
  while (made.size() < 500) {
    Configuration q = test::Cell::Start();
    q(0) = rng.Uniform(0, 1);
    q(1) = rng.Uniform(0.5, 1);
    q(2) = rng.Uniform(-3, 3);
    for (int i = 0; i < kArmJoints; ++i) {
      q(3 + i) += rng.Uniform(-1, 1);
    }
    if (!only_free || checker.Free(q)) {
      made.push_back(q);
    }
  }
  return made;
}

SensorTarget RandomTarget(Rng& rng) {
  return {{rng.Uniform(0.2, 1.1), rng.Uniform(0.3, 1.2), rng.Uniform(0.3, 1.2)},
          Vector3d{rng.Normal(), rng.Normal(), rng.Normal()}.normalized()};
}

void ForwardKinematics(benchmark::State& state) {
  const std::vector<Configuration> configurations = Configurations(false);
  std::size_t i = 0;
  for (auto _ : state) {
    const Kinematics<kArmJoints> body(TracerUf7(), configurations[i++ % configurations.size()]);
    benchmark::DoNotOptimize(body.p_WS());
  }
}
BENCHMARK(ForwardKinematics);

void AllSphereJacobians(benchmark::State& state) {
  const std::vector<Configuration> configurations = Configurations(false);
  std::size_t i = 0;
  for (auto _ : state) {
    const Kinematics<kArmJoints> body(TracerUf7(), configurations[i++ % configurations.size()]);
    for (const BodySphere& sphere : TracerUf7Shapes().spheres) {
      benchmark::DoNotOptimize(body.PointJacobian(sphere.body, sphere.p_L));
    }
  }
}
BENCHMARK(AllSphereJacobians);

void CheckConfiguration(benchmark::State& state) {
  const std::vector<Configuration> configurations = Configurations(state.range(0) != 0);
  const CollisionChecker checker(CellOfThreePipes().around());
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(checker.Free(configurations[i++ % configurations.size()]));
  }
}
BENCHMARK(CheckConfiguration)->ArgName("only_free")->Arg(0)->Arg(1);

void ReachTarget(benchmark::State& state) {
  const CollisionChecker checker(CellOfThreePipes().around());
  Rng rng(92);
  double reached = 0;
  for (auto _ : state) {
    reached += Reach(checker, RandomTarget(rng), test::Cell::Start(), rng).has_value() ? 1 : 0;
  }
  state.counters["reached"] = reached / static_cast<double>(state.iterations());
}
BENCHMARK(ReachTarget);

/// From goal to goal, as a mission goes.
void PlanMotion(benchmark::State& state) {
  const Surroundings around = CellOfThreePipes().around();
  const CollisionChecker checker(around);
  MotionPlanner planner;
  MotionPlanner::Path path;
  Configuration at = test::Cell::Start();
  Rng rng(93);
  double planned = 0;
  double duration_s = 0;
  double total_s = 0;
  for (auto _ : state) {
    state.PauseTiming();
    std::optional<Configuration> goal;
    while (!goal) {
      goal = Reach(checker, RandomTarget(rng), at, rng);
    }
    state.ResumeTiming();
    if (planner.Plan(around, at, *goal, rng, path, &duration_s) == Status::kOk) {
      ++planned;
      total_s += duration_s;
      at = *goal;
    }
  }
  state.counters["planned"] = planned / static_cast<double>(state.iterations());
  state.counters["motion_s"] = total_s / std::max(planned, 1.0);
}
BENCHMARK(PlanMotion)->Unit(benchmark::kMillisecond);

/// The whole budget spent in vain: the goal is behind a wall.
void PlanInVain(benchmark::State& state) {
  test::Cell cell;
  cell.AddBox({0.75, -0.5, 0}, {0.8, 1.95, 1.65});
  Configuration from = test::Cell::Start();
  from(0) = 0.1;
  Configuration to = from;
  to(0) = 1.4;
  MotionPlanner planner;
  MotionPlanner::Path path;
  double duration_s = 0;
  Rng rng(94);
  for (auto _ : state) {
    benchmark::DoNotOptimize(planner.Plan(cell.around(), from, to, rng, path, &duration_s));
  }
}
BENCHMARK(PlanInVain)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pipewright

BENCHMARK_MAIN();
