// SPDX-License-Identifier: MIT
#include "ctrl/constraints/row_selection.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/ctrl/constraints/random_world.h"

namespace pipewright {
namespace {

using test::RandomDirection;
using test::RandomIn;

struct Case {
  explicit Case(std::uint64_t seed) : rng(1, seed) {
    for (int i = 0; i < kControls; ++i) {
      lb(i) = -rng.Uniform(0, 1);
      ub(i) = rng.Uniform(0, 1);
    }
    z = rng.Uniform(0, 3);
  }
  ControlBox box() const { return {lb, ub, z}; }

  ChanceRow MakeRow() {
    ChanceRow row;
    for (int i = 0; i < kControls; ++i) {
      row.J.col(i) = RandomIn(rng, {-1, -1, -1}, {1, 1, 1});
    }
    const Vector3d n = RandomDirection(rng);
    row.a = -(row.J.transpose() * n);
    row.cone = PlaneCone(test::MakePlane(1, 0.3 * n, n, 1, 0.05, 0.02), Vector3d::Zero(), 1);
    row.limit = z * std::sqrt(row.cone.c) + rng.Uniform(0, 3);
    return row;
  }

  Controls Corner() {
    Controls u;
    for (int i = 0; i < kControls; ++i) {
      u(i) = rng.Uniform() < 0.5 ? lb(i) : ub(i);
    }
    return u;
  }

  Rng rng;
  Controls lb;
  Controls ub;
  double z = 0;
};

TEST(HeldPart, NoCornerOfThatPartOfTheBoxBreaksTheRow) {
  int less_than_all = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    Case c(i);
    const ChanceRow row = c.MakeRow();
    const double part = HeldPart(row, c.box());
    less_than_all += part < 1 ? 1 : 0;
    for (int corner = 0; corner < 200; ++corner) {
      EXPECT_LE(ChanceExcess(row, part * c.Corner(), c.z), 1e-12);
    }
  }
  EXPECT_GT(less_than_all, 50);
}

TEST(HeldPart, OfALinearRowIsTheLargest) {
  for (std::uint64_t i = 0; i < 300; ++i) {
    Case c(i);
    Row row;
    row.a = c.MakeRow().a;
    row.hi = c.rng.Uniform(0, 3);
    double most = 0;  // over all 512 corners
    for (int corner = 0; corner < 1 << kControls; ++corner) {
      double sum = 0;
      for (int k = 0; k < kControls; ++k) {
        sum += row.a(k) * ((corner >> k & 1) == 0 ? c.lb(k) : c.ub(k));
      }
      most = std::max(most, sum);
    }
    EXPECT_NEAR(HeldPart(row, c.box()), row.hi / most, 1e-12);
    row.lo = -row.hi;
    row.hi = 1e3;
    row.a = -row.a;
    EXPECT_NEAR(HeldPart(row, c.box()), -row.lo / most, 1e-12);  // the other side
  }
}

TEST(HeldPart, IsNegativeWhereStandingStillBreaksTheRow) {
  Case c(1);
  ChanceRow row = c.MakeRow();
  row.limit = c.z * std::sqrt(row.cone.c) - 0.01;
  EXPECT_LT(HeldPart(row, c.box()), 0);
}

/// Of n rows all but the kCapacity that hold in the least part go: what is left out then holds in
/// the (kCapacity + 1)-th smallest part, and no choice leaves out rows that hold in more.
TEST(RowSelection, LeavesOutWhatHoldsInMostOfTheBox) {
  constexpr int kCapacity = 8;
  for (std::uint64_t i = 0; i < 200; ++i) {
    Case c(i);
    FixedVector<ChanceRow, kCapacity> rows;
    RowSelection<ChanceRow, kCapacity> selection(rows, c.box());
    std::vector<double> parts;
    const int n = 1 + static_cast<int>(i % 40);
    for (int k = 0; k < n; ++k) {
      const ChanceRow row = c.MakeRow();
      parts.push_back(HeldPart(row, c.box()));
      selection.Add(row);
    }
    std::sort(parts.begin(), parts.end());
    std::vector<double> kept;
    for (const ChanceRow& row : rows) {
      kept.push_back(HeldPart(row, c.box()));
    }
    std::sort(kept.begin(), kept.end());
    const int expected = std::min(n, kCapacity);
    EXPECT_EQ(selection.dropped(), n - expected);
    EXPECT_EQ(kept, std::vector<double>(parts.begin(), parts.begin() + expected));
    EXPECT_EQ(selection.held(),
              n > kCapacity ? parts[kCapacity] : std::numeric_limits<double>::infinity());
  }
}

}  // namespace
}  // namespace pipewright
