// SPDX-License-Identifier: MIT
#include "plan/tour/tour_problem.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/plan/tour/tour_cases.h"

namespace pipewright {
namespace {

using test::Costs;
using test::RandomTour;
using test::TourCase;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

TEST(CheckTour, TakesAnyProblemThatIsAsItShouldBe) {
  for (const int n : {1, 2, 3, 40}) {
    TourCase c = RandomTour(n, Costs::kAny, 1);
    EXPECT_EQ(CheckTour(c.Problem()), Status::kOk);
    c.open = true;
    EXPECT_EQ(CheckTour(c.Problem()), Status::kOk);
    c.entry = n - 1;
    EXPECT_EQ(CheckTour(c.Problem()), Status::kOk);
  }
}

TEST(CheckTour, RefusesNoNodes) {
  EXPECT_EQ(CheckTour({}), Status::kOutOfRange);
  EXPECT_EQ(CheckTour({.n = -3}), Status::kOutOfRange);
}

TEST(CheckTour, RefusesCostsThatAreNotSquare) {
  TourCase c = RandomTour(4, Costs::kAny, 1);
  c.costs.pop_back();
  EXPECT_EQ(CheckTour(c.Problem()), Status::kMalformed);
}

TEST(CheckTour, RefusesACostThatIsNone) {
  for (const float bad : {kNan, kInf, -kInf, -1.0F, std::nextafter(TourProblem::kCostMax, kInf)}) {
    TourCase c = RandomTour(4, Costs::kAny, 1);
    c.costs[7] = bad;
    EXPECT_EQ(CheckTour(c.Problem()), Status::kOutOfRange) << bad;
  }
  TourCase c = RandomTour(4, Costs::kAny, 1);
  c.costs[7] = TourProblem::kCostMax;
  EXPECT_EQ(CheckTour(c.Problem()), Status::kOk);
}

TEST(CheckTour, RefusesEndsThatAreNone) {
  const struct {
    const char* name;
    bool open;
    int entry, exit;
    Status status;
  } rows[] = {
      {"entry beyond the nodes", true, 4, TourProblem::kFree, Status::kOutOfRange},
      {"exit beyond the nodes", true, TourProblem::kFree, 4, Status::kOutOfRange},
      {"entry below free", true, -2, TourProblem::kFree, Status::kOutOfRange},
      {"one node for both", true, 2, 2, Status::kInfeasible},
      {"entry of a closed tour", false, 2, TourProblem::kFree, Status::kMalformed},
      {"exit of a closed tour", false, TourProblem::kFree, 2, Status::kMalformed},
  };
  for (const auto& row : rows) {
    TourCase c = RandomTour(4, Costs::kAny, 1);
    c.open = row.open;
    c.entry = row.entry;
    c.exit = row.exit;
    EXPECT_EQ(CheckTour(c.Problem()), row.status) << row.name;
  }
}

TEST(TourCost, CountsTheWayBackOfAClosedTourAlone) {
  const TourCase c{.n = 3, .costs = {kNan, 1, 20, 300, kNan, 4000, 50000, 600000, kNan}};
  const TourNode order[] = {2, 0, 1};
  TourProblem problem = c.Problem();
  EXPECT_EQ(TourCost(problem, order), 50000 + 1 + 4000);
  problem.open = true;
  EXPECT_EQ(TourCost(problem, order), 50000 + 1);
}

}  // namespace
}  // namespace pipewright
