// SPDX-License-Identifier: MIT
#include "tests/plan/coverage/way_cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "platform/core/rng.h"

namespace pipewright::test {
namespace {

struct Point {
  double x = 0;
  double y = 0;
};

struct Rectangle {
  Point lo;
  Point hi;

  bool Holds(const Point& p) const {
    return lo.x <= p.x && p.x <= hi.x && lo.y <= p.y && p.y <= hi.y;
  }

  /// Whether the segment from a to b passes through the inside; along a side it does not.
  bool Hides(const Point& a, const Point& b) const {
    constexpr double kSide = 1e-9;
    double begin = 0;  // the part of it that is between the sides
    double end = 1;
    const auto clip = [&](double from, double to, double low, double high) {
      if (std::abs(to - from) < 1e-12) {
        end = low < from && from < high ? end : -1;
        return;
      }
      const double s = (low - from) / (to - from);
      const double t = (high - from) / (to - from);
      begin = std::max(begin, std::min(s, t));
      end = std::min(end, std::max(s, t));
    };
    clip(a.x, b.x, lo.x + kSide, hi.x - kSide);
    clip(a.y, b.y, lo.y + kSide, hi.y - kSide);
    return begin < end;
  }
};

double Distance(const Point& a, const Point& b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// The shortest ways between all points round the rectangles [Floyd 1962].
std::vector<double> ShortestWays(const std::vector<Point>& points,
                                 const std::vector<Rectangle>& rectangles) {
  const std::size_t n = points.size();
  std::vector<double> ways(n * n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      const bool hidden =
          std::any_of(rectangles.begin(), rectangles.end(),
                      [&](const Rectangle& r) { return r.Hides(points[i], points[j]); });
      ways[i * n + j] = hidden ? WayCase::kNoWay : Distance(points[i], points[j]);
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        ways[i * n + j] = std::min(ways[i * n + j], ways[i * n + k] + ways[k * n + j]);
      }
    }
  }
  return ways;
}

}  // namespace

std::vector<TourNode> WayCase::Goals() const {
  std::vector<TourNode> goals(n);
  std::iota(goals.begin(), goals.end(), TourNode{0});
  return goals;
}

GoalWays WayCase::Ways() const {
  GoalWays ways(n, symmetric);
  for (int i = 0; i < n; ++i) {
    EXPECT_EQ(ways.SetBounds(i, Goals(), [this](int from, int to) { return Bound(from, to); }),
              Status::kOk);
  }
  return ways;
}

WayCase PlaneWays(int n, int rectangles, Climb climb, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Rectangle> walls;
  for (int k = 0; k < rectangles; ++k) {
    const Point lo{rng.Uniform(), rng.Uniform()};
    walls.push_back({lo, {lo.x + rng.Uniform(0.05, 0.4), lo.y + rng.Uniform(0.05, 0.4)}});
  }
  std::vector<Point> points;
  while (std::ssize(points) < n) {
    const Point p{rng.Uniform(), rng.Uniform()};
    if (std::none_of(walls.begin(), walls.end(), [&](const Rectangle& r) { return r.Holds(p); })) {
      points.push_back(p);
    }
  }
  for (const Rectangle& r : walls) {
    points.insert(points.end(), {r.lo, r.hi, {r.lo.x, r.hi.y}, {r.hi.x, r.lo.y}});
  }
  const std::vector<double> ways = ShortestWays(points, walls);
  WayCase c{.n = n, .symmetric = climb == Climb::kNone};
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const std::size_t k = std::min(i, j) * points.size() + std::max(i, j);
      const double height = climb == Climb::kNone ? 0 : std::max(0.0, points[j].y - points[i].y);
      const double straight = Distance(points[i], points[j]);
      const double bound = climb == Climb::kUnknown ? straight : straight + height;
      const bool there = ways[k] < WayCase::kNoWay;
      c.bounds.push_back(static_cast<float>(bound));
      c.real.push_back(there ? static_cast<float>(std::max(ways[k], straight) + height)
                             : WayCase::kNoWay);
    }
  }
  return c;
}

WayCase RandomWays(int n, bool symmetric, int missing_percent, std::uint64_t seed) {
  Rng rng(seed);
  const auto pairs = static_cast<std::size_t>(n) * n;
  WayCase c{.n = n, .symmetric = symmetric};
  c.bounds.resize(pairs);
  c.real.resize(pairs);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const std::size_t k = static_cast<std::size_t>(i) * n + j;
      const std::size_t back = static_cast<std::size_t>(j) * n + i;
      const bool copy = symmetric && j < i;
      c.bounds[k] = copy ? c.bounds[back] : static_cast<float>(rng.Index(30));
      const float extra =
          rng.Index(100) < missing_percent ? WayCase::kNoWay : static_cast<float>(rng.Index(30));
      c.real[k] = copy ? c.real[back] : std::min(c.bounds[k] + extra, WayCase::kNoWay);
    }
  }
  return c;
}

Result<RealWay> CaseWays::Plan(int from, int to) {
  EXPECT_FALSE(WasAsked(from, to)) << from << " to " << to;
  EXPECT_TRUE(!case_.symmetric || from < to);
  asked_[static_cast<std::size_t>(from) * case_.n + to] = 1;
  ++count_;
  if (case_.Real(from, to) >= WayCase::kNoWay) {
    return Status::kInfeasible;
  }
  return RealWay{.length = case_.Real(from, to), .handle = from * case_.n + to};
}

void CaseWays::Forget(int goal) {
  for (int other = 0; other < case_.n; ++other) {
    asked_[static_cast<std::size_t>(goal) * case_.n + other] = 0;
    asked_[static_cast<std::size_t>(other) * case_.n + goal] = 0;
  }
}

}  // namespace pipewright::test
