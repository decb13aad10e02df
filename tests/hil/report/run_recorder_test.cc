// SPDX-License-Identifier: MIT
#include "hil/report/run_recorder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace pipewright::hil {
namespace {

const Plot* Find(const std::vector<Plot>& plots, const std::string& title) {
  for (const Plot& plot : plots) {
    if (plot.title == title) {
      return &plot;
    }
  }
  return nullptr;
}

CycleSample WholeCycle() {
  CycleSample s;
  s.true_plane_m = s.true_pipe_m = s.true_self_m = 0.1;
  s.seen_plane_m = s.seen_pipe_m = s.seen_self_m = s.seen_obstacle_m = 0.2;
  s.task_error = 0.5;
  s.base_mps = s.base_radps = 0.3;
  s.rows = 40;
  s.qp_iterations = 3;
  s.qp_us = 10;
  s.cycle_us = 20;
  return s;
}

MapSample WholeMap() {
  return {.coverage_ratio = 0.5,
          .free = 100,
          .occupied = 10,
          .unknown = 5,
          .covered = 4,
          .visual_entropy = 0.25,
          .coverage_entropy = 0.5,
          .base_bus_load = 0.06,
          .arm_bus_load = 0.17,
          .p_WP = Vector3d(0, 0, 1)};
}

TEST(RunRecorder, NamesEachSignalOnceAndInShownUnits) {
  RunRecorder recorder({.base_mps = 0.4, .joint_radps = 1, .period_us = 10000});
  recorder.Cycle(0, WholeCycle());
  recorder.Map(0, WholeMap());
  const std::vector<Plot> plots = recorder.Plots();
  std::size_t signals = 0;
  for (const Plot& plot : plots) {
    signals += plot.series.size();
    EXPECT_FALSE(plot.title.empty());
  }
  EXPECT_EQ(signals, 31u);
  EXPECT_EQ(Find(plots, "Coverage of what can be covered")->series[0].value[0], 50);
  EXPECT_EQ(Find(plots, "Entropy of the map")->series[0].value[0], 0.75);
  EXPECT_EQ(Find(plots, "Load of the CAN buses")->series[1].value[0], 17);
  EXPECT_EQ(Find(plots, "Joint speed commands")->limits.size(), 2u);
  EXPECT_TRUE(Find(plots, "Base turn command")->limits.empty());
  EXPECT_EQ(std::count_if(plots.begin(), plots.end(), [](const Plot& p) { return p.wall_clock; }),
            1);
}

TEST(RunRecorder, LeavesOutWhatNeverHadAValue) {
  RunRecorder recorder({});
  EXPECT_TRUE(recorder.Plots().empty());
  CycleSample s;
  s.true_self_m = 0.03;
  s.true_plane_m = INFINITY;
  recorder.Cycle(0, s);
  const std::vector<Plot> plots = recorder.Plots();
  ASSERT_NE(Find(plots, "Clearance as it was"), nullptr);
  EXPECT_EQ(Find(plots, "Clearance as it was")->series.size(), 1u);
  EXPECT_EQ(Find(plots, "Base speed command"), nullptr);
}

TEST(RunRecorder, TheHandsPathStaysSmallAndWhole) {
  RunRecorder recorder({});
  MapSample s;
  constexpr int kSteps = 30000;
  for (int i = 0; i <= kSteps; ++i) {
    s.p_WP = Vector3d(0.011 * i, 0, 1);
    recorder.Map(i, s);
  }
  s.p_WP = Vector3d::Constant(kNoReading);
  recorder.Map(kSteps + 1, s);
  const std::vector<Vector3d>& path = recorder.hand_path();
  EXPECT_LE(path.size(), 4000u);
  EXPECT_GE(path.size(), 1000u);
  EXPECT_EQ(path.front().x(), 0);
  EXPECT_NEAR(path.back().x(), 0.011 * kSteps, 0.2);
  double longest = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    longest = std::max(longest, (path[i] - path[i - 1]).norm());
  }
  EXPECT_LT(longest, 0.4);
}

TEST(RunRecorder, AStandingHandIsOnePoint) {
  RunRecorder recorder({});
  for (int i = 0; i < 100; ++i) {
    recorder.Map(i, {.p_WP = Vector3d(1, 1, 1)});
  }
  EXPECT_EQ(recorder.hand_path().size(), 1u);
}

}  // namespace
}  // namespace pipewright::hil
