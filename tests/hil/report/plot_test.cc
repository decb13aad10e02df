// SPDX-License-Identifier: MIT
#include "hil/report/plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/hil/report/page.h"

namespace pipewright::hil {
namespace {

struct Point {
  double x = 0;
  double y = 0;
  bool starts = false;
};

/// The points of a path of M, l, h commands, in the units of the SVG.
std::vector<Point> PointsOf(const std::string& path) {
  std::vector<Point> points;
  std::istringstream in(path);
  char command = 0;
  double x = 0;
  double y = 0;
  while (in >> command) {
    double a = 0;
    double b = 0;
    in >> a;
    if (command != 'h') {
      in >> b;
    }
    x = command == 'M' ? a : x + a;
    y = command == 'M' ? b : y + b;
    points.push_back({x / 10, y / 10, command == 'M'});
  }
  return points;
}

std::vector<Point> LineOf(const Plot& plot, double end_s) {
  const Page page(RenderPlot(plot, end_s));
  const auto lines = page.OfClass("line");
  EXPECT_EQ(lines.size(), 1u);
  return lines.empty() ? std::vector<Point>{} : PointsOf(lines[0]->Attribute("d"));
}

double TickY(const Page& page, const std::string& text) {
  for (const tinyxml2::XMLElement* e : page.OfClass("y")) {
    if (Page::Text(*e) == text) {
      return e->DoubleAttribute("y") - 3.5;  // the text hangs that much below its rule
    }
  }
  ADD_FAILURE() << "no tick " << text;
  return 0;
}

TEST(Plot, DrawsEachValueAtItsTickAndTime) {
  Plot plot{.title = "t", .series = {{"a", {0, 25, 50, 100}, {0, 4, 10, 2}}}};
  const std::vector<Point> points = LineOf(plot, 100);
  const Page page(RenderPlot(plot, 100));
  ASSERT_EQ(points.size(), 4u);
  EXPECT_NEAR(points[0].y, TickY(page, "0"), 0.11);
  EXPECT_NEAR(points[1].y, TickY(page, "4"), 0.11);
  EXPECT_NEAR(points[2].y, TickY(page, "10"), 0.11);
  EXPECT_NEAR(points[2].x, (points[0].x + points[3].x) / 2, 0.11);
  EXPECT_NEAR(points[1].x, (points[0].x + points[2].x) / 2, 0.11);
}

TEST(Plot, ALevelStretchKeepsItsEnds) {
  const Plot plot{.title = "t", .series = {{"a", {0, 1, 2, 3, 4}, {1, 1, 1, 1, 2}}}};
  const std::vector<Point> points = LineOf(plot, 4);
  ASSERT_EQ(points.size(), 3u);
  EXPECT_NEAR(points[1].x - points[0].x, 3 * (points[2].x - points[1].x), 0.5);
  EXPECT_EQ(points[1].y, points[0].y);
}

TEST(Plot, AGapBreaksTheLineAndALonePointIsADot) {
  const Plot plot{.title = "t", .series = {{"a", {0, 1, 2, 3, 4, 5}, {1, 2, NAN, 3, NAN, NAN}}}};
  const std::vector<Point> points = LineOf(plot, 5);
  ASSERT_EQ(points.size(), 4u);
  EXPECT_TRUE(points[0].starts);
  EXPECT_FALSE(points[1].starts);
  EXPECT_TRUE(points[2].starts);
  EXPECT_EQ(points[3].x, points[2].x);
}

TEST(Plot, ALogarithmicScaleSkipsWhatIsNotPositive) {
  const Plot plot{.title = "t",
                  .series = {{"a", {0, 1, 2, 3}, {1, 0, 10, 100}}},
                  .scale = PlotScale::kLogarithmic};
  const std::vector<Point> points = LineOf(plot, 3);
  ASSERT_EQ(points.size(), 4u);
  EXPECT_TRUE(points[2].starts);
  EXPECT_NEAR(points[0].y - points[2].y, points[2].y - points[3].y, 0.11);
}

TEST(Plot, KeepsTheOnePeakOfALongSignal) {
  Plot plot{.title = "t", .series = {{"a", {}, {}}}};
  for (int i = 0; i < 100000; ++i) {
    plot.series[0].t_s.push_back(0.01 * i);
    plot.series[0].value.push_back(i == 54321 ? 8 : (i % 2) * 0.5);
  }
  const std::string svg = RenderPlot(plot, 1000);
  EXPECT_LT(svg.size(), 20000u);
  const Page page(svg);
  const double peak = TickY(page, "8");
  int at_peak = 0;
  for (const Point& p : LineOf(plot, 1000)) {
    at_peak += std::abs(p.y - peak) < 0.11;
  }
  EXPECT_EQ(at_peak, 1);
}

TEST(Plot, EscapesAllItsTexts) {
  const std::string bad = "<b>&\"'";
  const Page page(RenderPlot({.title = bad,
                              .unit = bad,
                              .series = {{bad, {0}, {1}}, {bad, {0}, {1}}},
                              .limits = {{bad, 1}},
                              .note = bad},
                             1));
  EXPECT_EQ(Page::Text(*page.OfClass("limit-name").at(0)), bad);
  EXPECT_EQ(Page::Text(*page.OfClass("key").at(1)), bad);
  EXPECT_EQ(Page::Text(*page.OfClass("note").at(0)), bad);
  EXPECT_EQ(std::string(page.Named("svg").at(0)->Attribute("aria-label")), bad);
}

TEST(Plot, LanesAreApartAndShareTheirScale) {
  const Plot plot{.title = "t",
                  .series = {{"a", {0, 1}, {-1, 1}}, {"b", {0, 1}, {-1, 0.5}}},
                  .limits = {{"limit", 1}},
                  .lanes = true};
  const Page page(RenderPlot(plot, 1));
  const auto lines = page.OfClass("line");
  ASSERT_EQ(lines.size(), 2u);
  const std::vector<Point> a = PointsOf(lines[0]->Attribute("d"));
  const std::vector<Point> b = PointsOf(lines[1]->Attribute("d"));
  EXPECT_GT(b[1].y, a[0].y);
  EXPECT_NEAR(a[0].y - a[1].y, (b[0].y - b[1].y) * 2 / 1.5, 0.3);
  EXPECT_EQ(page.OfClass("limit").size(), 2u);
  EXPECT_EQ(page.OfClass("lane-name").size(), 2u);
}

TEST(Plot, OfNothingStillStands) {
  const Page page(RenderPlot({}, 0));
  EXPECT_EQ(page.Named("svg").size(), 1u);
  const Page lanes(RenderPlot({.lanes = true}, -1));
  EXPECT_EQ(lanes.Named("svg").size(), 1u);
}

}  // namespace
}  // namespace pipewright::hil
