// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "hil/report/series.h"

namespace pipewright::hil {

/// A horizontal line that values are held against.
struct Limit {
  std::string name{};
  double value = 0;
};

enum class PlotScale : unsigned char {
  kLinear,
  kLogarithmic,  ///< values that are not positive are gaps
};

/// Signals of one unit over time.
struct Plot {
  std::string title{};
  std::string unit{};
  std::vector<Series> series{};
  std::vector<Limit> limits{};
  PlotScale scale = PlotScale::kLinear;
  double ceiling = std::numeric_limits<double>::infinity();  ///< what is above is drawn there
  bool lanes = false;       ///< a lane for each series, on one scale
  bool wall_clock = false;  ///< differs between two runs of one seed
  std::string note{};       ///< what the reader should know; may be empty
};

/// The plot as one line of XHTML: a <figure> with its caption, legend and an inline SVG, coloured
/// by the page's style sheet. Series are thinned to Sampler::kMaxPoints, extremes kept.
///
/// The value axis holds all limits and all values up to the ceiling; a linear one also zero.
/// class="wall" marks a wall-clock figure, so that a comparison of two reports can leave such lines
/// out.
/// @param end_s  right end of the time axis; values after it are drawn at the edge
std::string RenderPlot(const Plot& plot, double end_s);

}  // namespace pipewright::hil
