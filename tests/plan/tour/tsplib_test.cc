// SPDX-License-Identifier: MIT
// The solver against optima that others have proven.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "plan/tour/tour_solver.h"
#include "tests/plan/tour/tsplib_file.h"

namespace pipewright {
namespace {

TEST(Tsplib, TheSolverFindsTheProvenOptimum) {
  constexpr const char* kFiles[] = {"br17.atsp",    "ftv33.atsp", "ft53.atsp",    "ftv70.atsp",
                                    "kro124p.atsp", "eil76.tsp",  "berlin52.tsp", "kroA100.tsp"};
  constexpr TourBudget kBudget{.trials = 20000};  // ten times what these take, and more
  TourSolver solver(128);
  for (const std::string file : kFiles) {
    SCOPED_TRACE(file);
    const auto read = test::ReadTsplibFile(PIPEWRIGHT_TEST_DATA "/tsplib/" + file);
    ASSERT_TRUE(read.instance) << read.error;
    std::vector<TourNode> order(read.instance->n);
    const auto figures = solver.Solve(read.instance->Problem(), kBudget, 1, order);
    ASSERT_TRUE(figures.ok());
    EXPECT_EQ(figures->cost, test::TsplibOptimum(read.instance->name));
    EXPECT_LE(figures->bound, figures->cost);
  }
}

}  // namespace
}  // namespace pipewright
