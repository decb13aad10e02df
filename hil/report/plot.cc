// SPDX-License-Identifier: MIT
#include "hil/report/plot.h"

#include <fmt/format.h>

#include <cmath>
#include <span>
#include <utility>

#include "hil/report/axis.h"
#include "hil/report/markup.h"

namespace pipewright::hil {
namespace {

// Sizes in units of the SVG, which is about one pixel on a desk.
constexpr int kWidth = 560;
constexpr int kLeft = 56;
constexpr int kRight = 10;
constexpr int kTop = 8;
constexpr int kBottom = 22;
constexpr int kHeight = 190;  ///< of the one lane
constexpr int kLaneHeight = 44;
constexpr int kLaneGap = 17;  ///< with the name of the lane below
constexpr int kColours = 7;   ///< in the style sheet

/// Where a lane is.
struct Lane {
  const Axis& time;
  const Axis& value;
  double top = 0;
  double height = 0;

  double X(double t_s) const { return kLeft + time.At(t_s) * (kWidth - kLeft - kRight); }
  double Y(double v) const { return top + (1 - value.At(v)) * height; }
};

int ColourOf(int series) { return series % kColours + 1; }

/// A polyline in tenths of a unit, relative, with what repeats a value left out.
class PathText {
 public:
  void Point(double x, double y) {
    const long px = std::lround(10 * x);
    const long py = std::lround(10 * y);
    if (!open_) {
      text_ += fmt::format("M{} {}", px, py);
      x_ = held_x_ = px;
      y_ = py;
      open_ = dot_ = true;
    } else if (py == y_) {
      held_x_ = px;
    } else {
      EndLevel();
      LineTo(px, py);
    }
  }
  void Gap() {
    EndLevel();
    if (open_ && dot_) {
      text_ += "h0";  // a lone point shows by its round cap
    }
    open_ = false;
  }
  std::string Take() {
    Gap();
    return std::move(text_);
  }

 private:
  void LineTo(long px, long py) {
    text_ += fmt::format("l{}{}{}", px - x_, py < y_ ? "" : " ", py - y_);
    x_ = held_x_ = px;
    y_ = py;
    dot_ = false;
  }
  void EndLevel() {
    if (open_ && held_x_ != x_) {
      LineTo(held_x_, y_);
    }
  }

  std::string text_;
  bool open_ = false;  ///< a stretch is being drawn
  bool dot_ = false;   ///< it has one point yet
  long x_ = 0;
  long y_ = 0;
  long held_x_ = 0;  ///< how far the level stretch goes
};

void Label(std::string& svg, const char* classes, double x, double y, const std::string& text) {
  svg += fmt::format(R"(<text class="{}" x="{:.1f}" y="{:.1f}">{}</text>)", classes, x, y, text);
}

void HorizontalRule(std::string& svg, const char* classes, double y) {
  svg += fmt::format(R"(<path class="{}" d="M{} {:.1f}H{}"/>)", classes, kLeft, y, kWidth - kRight);
}

void DrawGrid(std::string& svg, const Lane& lane) {
  for (const double tick : lane.value.ticks) {
    HorizontalRule(svg, tick == 0 ? "axis" : "grid", lane.Y(tick));
    Label(svg, "tick y", kLeft - 6, lane.Y(tick) + 3.5, Number(tick));
  }
}

void DrawTimeAxis(std::string& svg, const Axis& time, double bottom) {
  const double step = time.ticks.size() > 1 ? time.ticks[1] - time.ticks[0] : 1;
  for (const double tick : time.ticks) {
    if (tick > time.hi) {
      break;
    }
    const double x = kLeft + time.At(tick) * (kWidth - kLeft - kRight);
    svg += fmt::format(R"(<path class="grid" d="M{:.1f} {}V{:.1f}"/>)", x, kTop, bottom);
    const bool room_for_unit = time.hi - tick < 0.75 * step;
    if (x > kWidth - kRight - 12) {
      Label(svg, "tick y", kWidth - 2, bottom + 15, Number(tick) + " s");
    } else {
      Label(svg, "tick x", x, bottom + 15, Number(tick) + (room_for_unit ? " s" : ""));
    }
  }
}

void DrawSeries(std::string& svg, const Lane& lane, const Series& series, int colour) {
  const Series thin = Decimate(series);
  const bool logarithmic = lane.value.scale == PlotScale::kLogarithmic;
  PathText path;
  for (std::size_t i = 0; i < thin.value.size(); ++i) {
    if (!std::isfinite(thin.value[i]) || (logarithmic && thin.value[i] <= 0)) {
      path.Gap();
    } else {
      path.Point(lane.X(thin.t_s[i]), lane.Y(thin.value[i]));
    }
  }
  if (const std::string text = path.Take(); !text.empty()) {
    svg +=
        fmt::format(R"svg(<path class="line s{}" transform="scale(.1)" d="{}"/>)svg", colour, text);
  }
}

void DrawLimits(std::string& svg, const Lane& lane, std::span<const Limit> limits, bool named) {
  for (const Limit& limit : limits) {
    if (!std::isfinite(limit.value)) {
      continue;
    }
    const double y = lane.Y(limit.value);
    HorizontalRule(svg, "limit", y);
    if (named && !limit.name.empty()) {
      const double below = y < lane.top + 12 ? 11 : -4;
      Label(svg, "limit-name", kWidth - kRight - 3, y + below, Escape(limit.name));
    }
  }
}

std::string Legend(const Plot& plot) {
  std::string html;
  if (plot.lanes || plot.series.size() < 2) {
    return html;
  }
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    html += fmt::format(R"(<span class="key"><i class="s{}"></i>{}</span> )",
                        ColourOf(static_cast<int>(i)), Escape(plot.series[i].name));
  }
  return html;
}

double DrawLanes(std::string& svg, const Plot& plot, const Axis& time, const Axis& value) {
  double top = kTop + 7;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const Lane lane{time, value, top, kLaneHeight};
    DrawGrid(svg, lane);
    DrawSeries(svg, lane, plot.series[i], ColourOf(static_cast<int>(i)));
    DrawLimits(svg, lane, plot.limits, i == 0);
    Label(svg, "lane-name", kLeft, top - 3.5, Escape(plot.series[i].name));
    top += kLaneHeight + kLaneGap;
  }
  return top - kLaneGap;
}

double DrawOneLane(std::string& svg, const Plot& plot, const Axis& time, const Axis& value) {
  const Lane lane{time, value, kTop, kHeight};
  DrawGrid(svg, lane);
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    DrawSeries(svg, lane, plot.series[i], ColourOf(static_cast<int>(i)));
  }
  DrawLimits(svg, lane, plot.limits, true);
  return kTop + kHeight;
}

}  // namespace

std::string RenderPlot(const Plot& plot, double end_s) {
  Axis time = LinearAxis(0, end_s > 0 ? end_s : 1, 8);
  time.hi = end_s > 0 ? end_s : 1;
  const Axis value = ValueAxis(plot);
  std::string marks;
  const double bottom = plot.lanes && !plot.series.empty() ? DrawLanes(marks, plot, time, value)
                                                           : DrawOneLane(marks, plot, time, value);
  std::string svg;
  DrawTimeAxis(svg, time, bottom);
  svg += marks;
  const std::string unit =
      plot.unit.empty() ? "" : fmt::format(R"( <span class="unit">{}</span>)", Escape(plot.unit));
  const std::string note =
      plot.note.empty() ? "" : fmt::format(R"(<p class="note">{}</p>)", Escape(plot.note));
  return fmt::format(
      R"(<figure class="plot{}{}"><figcaption><b>{}</b>{} <span class="keys">{}</span></figcaption>)"
      R"(<svg viewBox="0 0 {} {:.0f}" role="img" aria-label="{}">{}</svg>{}</figure>)"
      "\n",
      plot.lanes ? " lanes" : "", plot.wall_clock ? " wall" : "", Escape(plot.title), unit,
      Legend(plot), kWidth, bottom + kBottom, Escape(plot.title), svg, note);
}

}  // namespace pipewright::hil
