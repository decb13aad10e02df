// SPDX-License-Identifier: MIT
#include "plan/tour/neighbours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/plan/tour/search_case.h"

namespace pipewright {
namespace {

using test::Costs;
using test::SearchCase;

/// The costs of the cheapest ways, by sorting all.
std::vector<float> Cheapest(const CostTable& costs, int node, bool out, std::size_t count) {
  std::vector<float> all;
  for (int i = 0; i < costs.size(); ++i) {
    if (i != node) {
      all.push_back(out ? costs(node, i) : costs(i, node));
    }
  }
  std::sort(all.begin(), all.end());
  all.resize(count);
  return all;
}

TEST(Neighbours, AreTheCheapestCheapestFirst) {
  for (const int n : {2, 5, Neighbours::kMost + 1, 40}) {
    for (const Costs kind : {Costs::kAny, Costs::kSymmetric, Costs::kUphill}) {
      const SearchCase c(n, kind, 4);
      const auto count = static_cast<std::size_t>(std::min(n - 1, Neighbours::kMost));
      for (TourNode a = 0; a < n; ++a) {
        std::vector<float> out;
        std::vector<float> in;
        for (const TourNode b : c.neighbours.Out(a)) {
          out.push_back(c.costs(a, b));
        }
        for (const TourNode b : c.neighbours.In(a)) {
          in.push_back(c.costs(b, a));
        }
        EXPECT_EQ(out, Cheapest(c.costs, a, true, count));
        EXPECT_EQ(in, Cheapest(c.costs, a, false, count));
        EXPECT_TRUE(std::equal(out.begin(), out.end(), c.neighbours.OutCosts(a).begin()));
      }
    }
  }
}

}  // namespace
}  // namespace pipewright
