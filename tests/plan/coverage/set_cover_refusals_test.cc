// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "plan/coverage/set_cover.h"
#include "tests/plan/coverage/cover_cases.h"
#include "tests/support/no_alloc_scope.h"

namespace pipewright {
namespace {

using test::CoverCase;
using Ids = std::vector<ConfigurationId>;

const CoverCase kTwo{.seen = {{0, 1}, {1, 2}}, .wanted = {1, 1, 1}, .candidates = {0, 1}};

class SetCoverRefusalsTest : public testing::Test {
 protected:
  /// How it ends, of kTwo changed so, after something was chosen.
  Status Ends(const CoverProblem& problem) {
    EXPECT_EQ(cover_.Solve(two_, kTwo.Problem()), Status::kOk);
    EXPECT_EQ(cover_.chosen().size(), 2U);
    return cover_.Solve(two_, problem);
  }
  void ExpectNothing() const {
    EXPECT_TRUE(cover_.chosen().empty());
    EXPECT_TRUE(cover_.shortfalls().empty());
    EXPECT_EQ(cover_.dropped(), 0);
    EXPECT_EQ(cover_.evaluations(), 0);
  }

  Observations two_ = kTwo.Observed();
  SetCover cover_{2, 3};
};

TEST_F(SetCoverRefusalsTest, WhatIsLargerThanItsRoom) {
  SetCover few_configurations(1, 3);
  SetCover few_primitives(2, 2);
  EXPECT_EQ(few_configurations.Solve(two_, kTwo.Problem()), Status::kFull);
  EXPECT_EQ(few_primitives.Solve(two_, kTwo.Problem()), Status::kFull);
  EXPECT_TRUE(few_primitives.chosen().empty());
}

TEST_F(SetCoverRefusalsTest, WantsThatAreNotOneAPrimitive) {
  const std::vector<std::uint8_t> two{1, 1};
  EXPECT_EQ(Ends({.wanted = two, .candidates = kTwo.candidates}), Status::kMalformed);
  ExpectNothing();
}

TEST_F(SetCoverRefusalsTest, ConfigurationsThatAreOfferedTwice) {
  const Ids twice{0, 0};
  const Ids one{1};
  EXPECT_EQ(Ends({.wanted = kTwo.wanted, .candidates = twice}), Status::kMalformed);
  ExpectNothing();
  EXPECT_EQ(Ends({.wanted = kTwo.wanted, .candidates = kTwo.candidates, .kept = one}),
            Status::kMalformed);
  ExpectNothing();
}

TEST_F(SetCoverRefusalsTest, ConfigurationsThatAreNotThere) {
  for (const ConfigurationId q : {-1, 2}) {
    const Ids absent{q};
    EXPECT_EQ(Ends({.wanted = kTwo.wanted, .candidates = absent}), Status::kOutOfRange);
    ExpectNothing();
    EXPECT_EQ(Ends({.wanted = kTwo.wanted, .kept = absent}), Status::kOutOfRange);
    ExpectNothing();
  }
}

TEST_F(SetCoverRefusalsTest, ConfigurationsThatWereRemoved) {
  EXPECT_EQ(two_.Remove(1), Status::kOk);
  EXPECT_EQ(cover_.Solve(two_, kTwo.Problem()), Status::kOutOfRange);
  ExpectNothing();
}

TEST_F(SetCoverRefusalsTest, PercentagesOutsideTheirLimits) {
  for (const int percent : {-1, 99, 10001}) {
    EXPECT_EQ(Ends({.wanted = kTwo.wanted, .candidates = kTwo.candidates, .kept_percent = percent}),
              Status::kOutOfRange);
    ExpectNothing();
  }
  for (const int percent : {100, 10000}) {
    EXPECT_EQ(Ends({.wanted = kTwo.wanted, .kept = kTwo.candidates, .kept_percent = percent}),
              Status::kOk);
    EXPECT_EQ(cover_.chosen().size(), 2U);
  }
}

TEST_F(SetCoverRefusalsTest, NothingWhereNothingIsWanted) {
  const std::vector<std::uint8_t> none(3, 0);
  EXPECT_EQ(Ends({.wanted = none, .candidates = kTwo.candidates}), Status::kOk);
  EXPECT_TRUE(cover_.chosen().empty());
}

TEST_F(SetCoverRefusalsTest, NothingButTellWhatIsMissingWhereNobodyIsOffered) {
  const std::vector<std::uint8_t> wanted{3, 0, 1};
  const std::vector<Shortfall> missing{{.primitive = 0, .missing = 3},
                                       {.primitive = 2, .missing = 1}};
  EXPECT_EQ(Ends({.wanted = wanted}), Status::kInfeasible);
  EXPECT_TRUE(cover_.chosen().empty());
  EXPECT_EQ(std::vector<Shortfall>(cover_.shortfalls().begin(), cover_.shortfalls().end()),
            missing);
}

TEST_F(SetCoverRefusalsTest, NobodyWhoSeesNothing) {
  const CoverCase blind{.seen = {{}, {}}, .wanted = {1, 0, 0}, .candidates = {0}, .kept = {1}};
  EXPECT_EQ(cover_.Solve(blind.Observed(), blind.Problem()), Status::kInfeasible);
  EXPECT_TRUE(cover_.chosen().empty());
}

TEST_F(SetCoverRefusalsTest, NotThatThereIsNothingAtAll) {
  SetCover empty(0, 0);
  EXPECT_EQ(empty.Solve(Observations({}), {}), Status::kOk);
  EXPECT_TRUE(empty.chosen().empty());
}

TEST_F(SetCoverRefusalsTest, AnythingFromTheHeap) {
  const CoverCase c = test::RandomCover(300, 1000, 3, 7);
  const Observations observations = c.Observed();
  SetCover cover(300, 1000);
  const test::NoAllocScope no_alloc;
  EXPECT_NE(cover.Solve(observations, c.Problem()), Status::kFull);
  EXPECT_GT(cover.chosen().size(), 20U);
}

TEST_F(SetCoverRefusalsTest, NoMemoryButWhatItSays) {
  EXPECT_EQ(SetCover(5000, 100'000).MemoryBytes(), 5000U * 13 + 100'000U * 12);
}

}  // namespace
}  // namespace pipewright
