// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "hil/report/plot.h"

namespace pipewright::hil {

/// A range of values and the round numbers in it that get a tick.
struct Axis {
  double lo = 0;
  double hi = 1;
  PlotScale scale = PlotScale::kLinear;
  std::vector<double> ticks;

  /// 0 at lo, 1 at hi; values outside are held at the ends.
  double At(double value) const;
};

/// An axis that holds [lo, hi] and ends on ticks, 1, 2, 2.5 or 5 times a power of ten apart, about
/// `intervals` of them. An empty range grows about its value.
Axis LinearAxis(double lo, double hi, int intervals);

/// Whole decades that hold [lo, hi], lo > 0; at most six, the highest. One tick a decade.
Axis LogarithmicAxis(double lo, double hi);

/// The axis that RenderPlot gives a plot's values.
Axis ValueAxis(const Plot& plot);

}  // namespace pipewright::hil
