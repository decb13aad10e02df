// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "plan/coverage/goal_ways.h"
#include "plan/coverage/multi_goal.h"
#include "tests/plan/tour/tour_cases.h"

namespace pipewright::test {

/// All ways between n goals, n×n, bounds and real lengths; a way that is not there is kNoWay long.
struct WayCase {
  static constexpr float kNoWay = 1e6F;

  int n = 0;
  bool symmetric = true;
  std::vector<float> bounds = {};
  std::vector<float> real = {};

  float& Real(int from, int to) { return real[static_cast<std::size_t>(from) * n + to]; }
  float Real(int from, int to) const { return real[static_cast<std::size_t>(from) * n + to]; }
  float Bound(int from, int to) const { return bounds[static_cast<std::size_t>(from) * n + to]; }
  std::vector<TourNode> Goals() const;
  /// With all bounds, and nothing planned.
  GoalWays Ways() const;
  /// Closed, of the real lengths.
  TourCase RealTour() const { return {.n = n, .costs = real}; }
};

enum class Climb : std::uint8_t {
  kNone,     ///< ways are as long as their way back
  kKnown,    ///< each is longer by what it climbs
  kUnknown,  ///< the same, but its bound is not
};

/// Goals in a unit square with rectangles in it, which may overlap: bounds are distances, real ways
/// the shortest round the rectangles, by the graph of the corners that see each other. A goal is
/// within no rectangle, but all others may be shut off from it.
WayCase PlaneWays(int n, int rectangles, Climb climb, std::uint64_t seed);

/// Whole numbers, each way on its own, that many of 100 not there.
WayCase RandomWays(int n, bool symmetric, int missing_percent, std::uint64_t seed);

/// Answers by the case, and fails the test where a way is asked for twice, or the wrong way round.
class CaseWays : public WayPlanner {
 public:
  explicit CaseWays(const WayCase& c) : case_(c), asked_(c.real.size()) {}
  /// The handle is from · n + to.
  Result<RealWay> Plan(int from, int to) override;
  /// As if never asked for.
  void Forget(int goal);
  bool WasAsked(int from, int to) const {
    return asked_[static_cast<std::size_t>(from) * case_.n + to] != 0;
  }
  int count() const { return count_; }

 private:
  const WayCase& case_;
  std::vector<std::uint8_t> asked_;
  int count_ = 0;
};

}  // namespace pipewright::test
