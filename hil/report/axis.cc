// SPDX-License-Identifier: MIT
#include "hil/report/axis.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace pipewright::hil {
namespace {

constexpr int kMaxDecades = 6;

double RoundStep(double raw) {
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double step : {1.0, 2.0, 2.5, 5.0}) {
    if (raw <= step * power * (1 + 1e-9)) {
      return step * power;
    }
  }
  return 10 * power;
}

struct Extent {
  double lo = std::numeric_limits<double>::infinity();
  double hi = -std::numeric_limits<double>::infinity();

  void Add(double value) {
    lo = std::min(lo, value);
    hi = std::max(hi, value);
  }
};

}  // namespace

double Axis::At(double value) const {
  const auto place = [this](double v) {
    return scale == PlotScale::kLogarithmic ? std::log10(v) : v;
  };
  const double held = std::clamp(value, lo, hi);
  return (place(held) - place(lo)) / (place(hi) - place(lo));
}

Axis LinearAxis(double lo, double hi, int intervals) {
  assert(lo <= hi && intervals >= 1);
  if (hi - lo <= 1e-12 * std::max(std::abs(lo), std::abs(hi))) {
    const double margin = lo == 0 ? 1 : std::abs(lo) / 2;
    lo -= lo > 0 || lo < 0 ? margin : 0;
    hi += margin;
  }
  const double step = RoundStep((hi - lo) / intervals);
  Axis axis;
  const double first = std::floor(lo / step + 1e-9);
  const double last = std::ceil(hi / step - 1e-9);
  const int intervals_taken = static_cast<int>(last - first);
  for (int k = 0; k <= intervals_taken; ++k) {
    axis.ticks.push_back((first + k) * step);
  }
  axis.lo = first * step;
  axis.hi = last * step;
  return axis;
}

Axis LogarithmicAxis(double lo, double hi) {
  assert(0 < lo && lo <= hi);
  const int last = static_cast<int>(std::ceil(std::log10(hi) - 1e-9));
  const int lowest = static_cast<int>(std::floor(std::log10(lo) + 1e-9));
  const int first = std::max(std::min(lowest, last - 1), last - kMaxDecades);
  Axis axis;
  axis.scale = PlotScale::kLogarithmic;
  for (int k = first; k <= last; ++k) {
    axis.ticks.push_back(std::pow(10.0, k));
  }
  axis.lo = axis.ticks.front();
  axis.hi = axis.ticks.back();
  return axis;
}

Axis ValueAxis(const Plot& plot) {
  const bool logarithmic = plot.scale == PlotScale::kLogarithmic;
  Extent extent;
  const auto add = [&](double value) {
    if (std::isfinite(value) && (!logarithmic || value > 0)) {
      extent.Add(std::min(value, plot.ceiling));
    }
  };
  for (const Series& s : plot.series) {
    std::for_each(s.value.begin(), s.value.end(), add);
  }
  for (const Limit& limit : plot.limits) {
    add(limit.value);
  }
  if (logarithmic) {
    return extent.lo > extent.hi ? LogarithmicAxis(1, 10) : LogarithmicAxis(extent.lo, extent.hi);
  }
  extent.Add(0);
  if (!plot.lanes) {
    return LinearAxis(extent.lo, extent.hi, 5);
  }
  Axis axis = LinearAxis(extent.lo, extent.hi, 8);  // a low lane has room for its ends and zero
  axis.ticks = {axis.lo};
  if (axis.lo < 0 && axis.hi > 0) {
    axis.ticks.push_back(0);
  }
  axis.ticks.push_back(axis.hi);
  return axis;
}

}  // namespace pipewright::hil
