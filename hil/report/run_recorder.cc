// SPDX-License-Identifier: MIT
#include "hil/report/run_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace pipewright::hil {
namespace {

constexpr std::size_t kMaxPath = 4000;

bool HasValue(const Series& series) {
  return std::any_of(series.value.begin(), series.value.end(),
                     [](double v) { return std::isfinite(v); });
}

std::vector<Limit> BothWays(double limit) {
  if (!std::isfinite(limit)) {
    return {};
  }
  return {{"limit", limit}, {"", -limit}};
}

std::vector<Limit> OneLimit(const char* name, double limit) {
  return std::isfinite(limit) ? std::vector<Limit>{{name, limit}} : std::vector<Limit>{};
}

}  // namespace

RunRecorder::RunRecorder(const RunLimits& limits) : limits_(limits) {}

void RunRecorder::Cycle(double t_s, const CycleSample& s) {
  const std::pair<Signal, double> values[] = {
      {kTruePlane, s.true_plane_m},
      {kTruePipe, s.true_pipe_m},
      {kTrueSelf, s.true_self_m},
      {kSeenPlane, s.seen_plane_m},
      {kSeenPipe, s.seen_pipe_m},
      {kSeenSelf, s.seen_self_m},
      {kTaskError, s.task_error},
      {kSeenObstacle, s.seen_obstacle_m},
      {kBaseSpeed, s.base_mps},
      {kBaseTurn, s.base_radps},
      {kRows, s.rows},
      {kQpIterations, s.qp_iterations},
      {kQpTime, s.qp_us},
      {kCycleTime, s.cycle_us},
  };
  for (const auto& [signal, value] : values) {
    signals_[signal].Add(t_s, value);
  }
  for (std::size_t i = 0; i < s.joint_radps.size(); ++i) {
    signals_[kJoint1 + i].Add(t_s, s.joint_radps[i]);
  }
}

void RunRecorder::Map(double t_s, const MapSample& s) {
  const std::pair<Signal, double> values[] = {
      {kCoverage, 100 * s.coverage_ratio},
      {kFree, s.free},
      {kOccupied, s.occupied},
      {kUnknown, s.unknown},
      {kCovered, s.covered},
      {kVisualEntropy, s.visual_entropy},
      {kCoverageEntropy, s.coverage_entropy},
      {kCombinedEntropy, s.visual_entropy + s.coverage_entropy},
      {kBaseBus, 100 * s.base_bus_load},
      {kArmBus, 100 * s.arm_bus_load},
  };
  for (const auto& [signal, value] : values) {
    signals_[signal].Add(t_s, value);
  }
  AddToPath(s.p_WP);
}

void RunRecorder::AddToPath(const Vector3d& p_WP) {
  if (!p_WP.allFinite() ||
      (!hand_path_.empty() && (p_WP - hand_path_.back()).norm() < path_step_m_)) {
    return;
  }
  if (hand_path_.size() == kMaxPath) {
    for (std::size_t i = 0; i < kMaxPath / 2; ++i) {
      hand_path_[i] = hand_path_[2 * i];
    }
    hand_path_.resize(kMaxPath / 2);
    path_step_m_ *= 2;
  }
  hand_path_.push_back(p_WP);
}

Plot RunRecorder::MakePlot(Plot head,
                           std::initializer_list<std::pair<Signal, const char*>> signals) const {
  for (const auto& [signal, name] : signals) {
    if (Series series = signals_[signal].Take(name); HasValue(series)) {
      head.series.push_back(std::move(series));
    }
  }
  return head;
}

std::vector<Plot> RunRecorder::Plots() const {
  const std::string target = fmt::format("target {:g} %", 100 * limits_.coverage_target);
  Plot joints{.title = "Joint speed commands",
              .unit = "rad/s",
              .limits = BothWays(limits_.joint_radps),
              .lanes = true};
  for (int i = 0; i < 7; ++i) {
    if (Series s = signals_[kJoint1 + i].Take(fmt::format("joint {}", i + 1)); HasValue(s)) {
      joints.series.push_back(std::move(s));
    }
  }
  constexpr double kFar_m = 0.5;  // above, how far exactly says nothing
  const std::vector<Limit> contact = {{"contact", 0}};
  const std::vector<Limit> period = OneLimit("period", limits_.period_us);
  std::vector<Plot> plots = {
      MakePlot({.title = "Coverage of what can be covered",
                .unit = "%",
                .limits = {{target, 100 * limits_.coverage_target}},
                .note = "Ground truth: surface voxels the probe has covered."},
               {{kCoverage, "covered"}}),
      MakePlot({.title = "Entropy of the map", .unit = "nats per voxel"},
               {{kCombinedEntropy, "combined"},
                {kVisualEntropy, "visual"},
                {kCoverageEntropy, "coverage"}}),
      MakePlot({.title = "Space in the map", .unit = "voxels of the workspace"},
               {{kFree, "free"}, {kUnknown, "unknown"}}),
      MakePlot({.title = "Surface in the map", .unit = "voxels of the workspace"},
               {{kOccupied, "occupied"}, {kCovered, "covered"}}),
      MakePlot({.title = "Clearance as it was",
                .unit = "m",
                .limits = contact,
                .ceiling = kFar_m,
                .note = "Ground truth: the nearest body of the robot to walls and floor, to pipes, "
                        "to itself. Above 0.5 m at the edge."},
               {{kTruePlane, "walls"}, {kTruePipe, "pipes"}, {kTrueSelf, "itself"}}),
      MakePlot(
          {.title = "Clearance as the robot saw it",
           .unit = "m",
           .limits = contact,
           .ceiling = kFar_m,
           .note = "Gaps: nothing was near enough to be constrained. Above 0.5 m at the edge."},
          {{kSeenPlane, "walls"},
           {kSeenPipe, "pipes"},
           {kSeenSelf, "itself"},
           {kSeenObstacle, "obstacle or unknown voxels"}}),
      MakePlot({.title = "Task error ‖x − x_d‖",
                .limits = OneLimit("reached", limits_.reached),
                .scale = PlotScale::kLogarithmic},
               {{kTaskError, "error"}}),
      MakePlot({.title = "Base speed command", .unit = "m/s", .limits = BothWays(limits_.base_mps)},
               {{kBaseSpeed, "forward"}}),
      MakePlot(
          {.title = "Base turn command", .unit = "rad/s", .limits = BothWays(limits_.base_radps)},
          {{kBaseTurn, "turn"}}),
      std::move(joints),
      MakePlot({.title = "Size of the QP", .unit = "count a cycle"},
               {{kRows, "constraint rows"}, {kQpIterations, "iterations"}}),
      MakePlot({.title = "Control cycle, wall clock",
                .unit = "µs",
                .limits = period,
                .scale = PlotScale::kLogarithmic,
                .wall_clock = true,
                .note = "Of this machine; not the same in a second run."},
               {{kCycleTime, "whole cycle"}, {kQpTime, "QP"}}),
      MakePlot({.title = "Load of the CAN buses", .unit = "% of the last second"},
               {{kBaseBus, "base"}, {kArmBus, "arm"}}),
  };
  std::erase_if(plots, [](const Plot& plot) { return plot.series.empty(); });
  return plots;
}

}  // namespace pipewright::hil
