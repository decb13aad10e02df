// SPDX-License-Identifier: MIT
#include "plan/tour/array_tour.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "tests/plan/tour/tour_cases.h"

namespace pipewright {
namespace {

using test::Costs;
using test::RandomTour;
using test::TourCase;

/// The order from `first` on, following Next.
std::vector<TourNode> From(const ArrayTour& tour, TourNode first) {
  std::vector<TourNode> order{first};
  for (TourNode a = tour.Next(first); a != first; a = tour.Next(a)) {
    order.push_back(a);
  }
  return order;
}

void ExpectConsistent(const ArrayTour& tour, const TourCase& c, const CostTable& costs) {
  double length = 0;
  for (TourNode a = 0; a < tour.size(); ++a) {
    EXPECT_EQ(tour.Previous(tour.Next(a)), a);
    EXPECT_EQ(tour.Steps(a, tour.Next(a)), 1);
    EXPECT_EQ(tour.CostOut(a), costs(a, tour.Next(a)));
    length += costs(a, tour.Next(a));
  }
  EXPECT_NEAR(tour.Length(), length, 1e-9);
  EXPECT_NEAR(tour.Length(), TourCost(c.Problem(), tour.order()), 1e-5);
}

class ArrayTourTest : public testing::Test {
 protected:
  static constexpr int kNodes = 7;

  void Load(Costs kind) {
    case_ = RandomTour(kNodes, kind, 11);
    costs_.Load(case_.Problem(), true);
    std::vector<TourNode> order(kNodes);
    std::iota(order.begin(), order.end(), TourNode{0});
    std::rotate(order.begin(), order.begin() + rotated_, order.end());
    tour_.Assign(order, costs_);
  }

  int rotated_ = 0;  // where the array begins, which must not matter
  TourCase case_;
  CostTable costs_{kNodes, 0};
  ArrayTour tour_{kNodes};
};

TEST_F(ArrayTourTest, ExchangesPiecesWhereverTheyLie) {
  for (rotated_ = 0; rotated_ < kNodes; ++rotated_) {
    for (int a = 0; a < kNodes; ++a) {
      for (int to_b = 1; to_b < kNodes - 1; ++to_b) {
        for (int to_c = to_b + 1; to_c < kNodes; ++to_c) {
          Load(Costs::kAny);
          const auto node = [&](int steps) { return static_cast<TourNode>((a + steps) % kNodes); };
          tour_.ExchangePieces(node(0), node(to_b), node(to_c), costs_);
          std::vector<TourNode> expected{node(0)};
          for (int k = to_b + 1; k <= to_c; ++k) {
            expected.push_back(node(k));
          }
          for (int k = 1; k <= to_b; ++k) {
            expected.push_back(node(k));
          }
          for (int k = to_c + 1; k < kNodes; ++k) {
            expected.push_back(node(k));
          }
          ASSERT_EQ(From(tour_, node(0)), expected) << a << ' ' << to_b << ' ' << to_c;
          ExpectConsistent(tour_, case_, costs_);
        }
      }
    }
  }
}

TEST_F(ArrayTourTest, TurnsAPieceOrAllElse) {
  for (rotated_ = 0; rotated_ < kNodes; ++rotated_) {
    for (int a = 0; a < kNodes; ++a) {
      for (int to_c = 1; to_c < kNodes; ++to_c) {
        Load(Costs::kSymmetric);
        const auto node = [&](int steps) { return static_cast<TourNode>((a + steps) % kNodes); };
        tour_.TurnPiece(node(0), node(to_c), costs_);
        std::vector<TourNode> expected{node(0)};
        for (int k = to_c; k >= 1; --k) {
          expected.push_back(node(k));
        }
        for (int k = to_c + 1; k < kNodes; ++k) {
          expected.push_back(node(k));
        }
        std::vector<TourNode> backwards = expected;  // the same tour
        std::reverse(backwards.begin() + 1, backwards.end());
        const std::vector<TourNode> found = From(tour_, node(0));
        ASSERT_TRUE(found == expected || found == backwards) << a << ' ' << to_c;
        ExpectConsistent(tour_, case_, costs_);
      }
    }
  }
}

}  // namespace
}  // namespace pipewright
