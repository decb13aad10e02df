// SPDX-License-Identifier: MIT
#include "tests/bench/control_figures.h"

#include <algorithm>
#include <cmath>

namespace pipewright::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kStill = 0.01;  ///< no control above this [m/s, rad/s]: the robot stands

CycleFigures FiguresOf(const ControlReport& report, double us) {
  const ControlStats& stats = report.stats;
  CycleFigures f;
  f.us = f.own_us = static_cast<float>(us);
  f.qp_us = 1e-3F * static_cast<float>(stats.qp_ns);
  f.rows = static_cast<std::int16_t>(stats.rows);
  f.dropped = static_cast<std::int16_t>(stats.dropped_rows);
  f.rounds = static_cast<std::int16_t>(stats.qp.rounds);
  f.iterations = static_cast<std::int16_t>(stats.qp.iterations);
  return f;
}

/// The smallest value that at least a share p does not exceed; 0 for none.
double Percentile(std::vector<float>& values, double p) {
  if (values.empty()) {
    return 0;
  }
  const double rank = std::ceil(p * static_cast<double>(values.size()));
  const auto k = static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return static_cast<double>(values[static_cast<std::size_t>(k)]);
}

Json Spread(std::vector<float> values) {
  return {{"p50", Percentile(values, 0.5)},
          {"p99", Percentile(values, 0.99)},
          {"p99.99", Percentile(values, 0.9999)},
          {"max", Percentile(values, 1)}};
}

/// Of one figure over the cycles that `which` takes.
template <typename Figure, typename Which>
Json SpreadOf(const std::vector<CycleFigures>& cycles, Figure figure, const Which& which) {
  std::vector<float> values;
  for (const CycleFigures& cycle : cycles) {
    if (which(cycle)) {
      values.push_back(static_cast<float>(cycle.*figure));
    }
  }
  return Spread(std::move(values));
}

}  // namespace

void ControlFigures::Add(const ControlReport& report, double us, bool preempted) {
  const ControlStats& stats = report.stats;
  cycles_.push_back(FiguresOf(report, us));
  cycles_.back().preempted = preempted;
  many_rows_ += cycles_.back().many_rows() ? 1 : 0;
  moving_ += report.sent.cwiseAbs().maxCoeff() > kStill ? 1 : 0;
  clamped_ += stats.clamped_rows > 0 ? 1 : 0;
  invalid_ += report.state.valid ? 0 : 1;
  box_part_ = std::min(box_part_, stats.box_part);
  cap_hits_ += stats.qp.status == QpStatus::kCapped ? 1 : 0;
  not_optimal_ += stats.qp.status == QpStatus::kOptimal ? 0 : 1;
  fallbacks_ += stats.qp.fallbacks;
}

bool ControlFigures::Repeat(std::size_t i, const ControlReport& report, double us) {
  const CycleFigures now = FiguresOf(report, us);
  CycleFigures& first = cycles_[i];
  first.own_us = std::min(first.own_us, now.us);
  return now.rows == first.rows && now.dropped == first.dropped && now.rounds == first.rounds &&
         now.iterations == first.iterations;
}

Json ControlFigures::ToJson() const {
  const auto share = [this](int part) {
    return cycles_.empty() ? 0.0 : static_cast<double>(part) / static_cast<double>(cycles_.size());
  };
  const auto all = [](const CycleFigures&) { return true; };
  const auto many = [](const CycleFigures& cycle) { return cycle.many_rows(); };
  const auto undisturbed = [](const CycleFigures& cycle) { return !cycle.preempted; };
  int preempted = 0;
  int dropping = 0;
  CycleFigures largest;
  std::size_t at = 0;
  for (std::size_t i = 0; i < cycles_.size(); ++i) {
    preempted += cycles_[i].preempted ? 1 : 0;
    dropping += cycles_[i].dropped > 0 ? 1 : 0;
    if (cycles_[i].own_us > largest.own_us) {
      largest = cycles_[i];
      at = i;
    }
  }
  return {{"cycles", cycles_.size()},
          {"cycles_120_rows", many_rows_},
          {"rows", SpreadOf(cycles_, &CycleFigures::rows, all)},
          {"share_moving", share(moving_)},
          {"share_clamped", share(clamped_)},
          {"invalid_states", invalid_},
          {"share_dropping", share(dropping)},
          {"dropped_rows", SpreadOf(cycles_, &CycleFigures::dropped, all)},
          {"box_part_min", box_part_},
          {"cycle_us", SpreadOf(cycles_, &CycleFigures::us, all)},
          {"cycle_us_120_rows", SpreadOf(cycles_, &CycleFigures::us, many)},
          {"cycle_us_undisturbed", SpreadOf(cycles_, &CycleFigures::us, undisturbed)},
          {"preempted_cycles", preempted},
          {"own_us", SpreadOf(cycles_, &CycleFigures::own_us, all)},
          {"own_us_120_rows", SpreadOf(cycles_, &CycleFigures::own_us, many)},
          {"own_largest",
           {{"cycle", at},
            {"first_pass_us", largest.us},
            {"own_us", largest.own_us},
            {"rows", largest.rows},
            {"rounds", largest.rounds},
            {"iterations", largest.iterations}}},
          {"qp_us", SpreadOf(cycles_, &CycleFigures::qp_us, all)},
          {"qp_rounds", SpreadOf(cycles_, &CycleFigures::rounds, all)},
          {"qp_iterations", SpreadOf(cycles_, &CycleFigures::iterations, all)},
          {"qp_cap_hits", cap_hits_},
          {"qp_not_optimal", not_optimal_},
          {"svfi_fallbacks", fallbacks_}};
}

}  // namespace pipewright::bench
