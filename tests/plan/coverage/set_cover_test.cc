// SPDX-License-Identifier: MIT
#include "plan/coverage/set_cover.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "platform/core/rng.h"
#include "tests/plan/coverage/cover_cases.h"

namespace pipewright {
namespace {

using test::CoverCase;
using test::RandomCover;
using Ids = std::vector<ConfigurationId>;

const bool kSeeded = setenv("RC_PARAMS", "seed=20261124 max_success=2000", 0) == 0;

CoverCase AnyCover(int configurations, int primitives, int redundancy) {
  return RandomCover(*rc::gen::inRange(0, configurations + 1), *rc::gen::inRange(0, primitives + 1),
                     *rc::gen::inRange(1, redundancy + 1), *rc::gen::arbitrary<unsigned>());
}

void Shuffle(Ids& ids, Rng& rng) {
  for (int k = static_cast<int>(ids.size()) - 1; k > 0; --k) {
    std::swap(ids[k], ids[rng.Index(k + 1)]);
  }
}

class SetCoverTest : public testing::Test {
 protected:
  SetCoverTest() { EXPECT_TRUE(kSeeded); }

  /// Of one SetCover for all, so that none may depend on the one before.
  Ids Chosen(const CoverCase& c) { return Chosen(c, c.Observed()); }
  Ids Chosen(const CoverCase& c, const Observations& observations) {
    status_ = cover_.Solve(observations, c.Problem());
    return {cover_.chosen().begin(), cover_.chosen().end()};
  }

  SetCover cover_{80, 120};
  Status status_ = Status::kOk;
};

TEST_F(SetCoverTest, ChoosesAndDropsAsIfAllWereEvaluatedEveryTime) {
  int dropping = 0;  // cases in which the order of pruning may matter
  EXPECT_TRUE(rc::check("equal to naive greedy", [&] {
    const CoverCase c = AnyCover(80, 120, 4);
    const Ids chosen = Chosen(c);
    const Ids naive = test::NaiveGreedy(c);
    RC_ASSERT(chosen == test::NaivelyPruned(c, naive));
    dropping += cover_.dropped() > 1;
    RC_ASSERT(cover_.dropped() == std::ssize(naive) - std::ssize(chosen));
  }));
  EXPECT_GT(dropping, 50);
}

TEST_F(SetCoverTest, SeesAllThatCanBeAndTellsTheRest) {
  EXPECT_TRUE(rc::check("seen or told", [this] {
    const CoverCase c = AnyCover(40, 120, 6);
    RC_ASSERT(test::SeesAllThatCanBe(c, Chosen(c)));
    const std::vector<Shortfall> missing = test::MissingOf(c);
    RC_ASSERT(status_ == (missing.empty() ? Status::kOk : Status::kInfeasible));
    RC_ASSERT(std::equal(missing.begin(), missing.end(), cover_.shortfalls().begin(),
                         cover_.shortfalls().end()));
  }));
}

TEST_F(SetCoverTest, ChoosesNoneThatIsNotNeeded) {
  EXPECT_TRUE(rc::check("all needed", [this] {
    const CoverCase c = AnyCover(80, 60, 4);
    const Ids chosen = Chosen(c);
    for (const ConfigurationId q : chosen) {
      Ids without = chosen;
      std::erase(without, q);
      RC_ASSERT(!test::SeesAllThatCanBe(c, without));
    }
  }));
}

TEST_F(SetCoverTest, DoesNotDependOnAnyOrder) {
  EXPECT_TRUE(rc::check("the same choices", [this] {
    CoverCase c = AnyCover(60, 120, 3);
    const Ids chosen = Chosen(c);
    Rng rng(*rc::gen::arbitrary<unsigned>());
    Shuffle(c.candidates, rng);
    Shuffle(c.kept, rng);
    Observations observations = c.Observed();
    Ids again = c.Offered();  // other pages for what they see
    Shuffle(again, rng);
    for (const ConfigurationId q : again) {
      RC_ASSERT(observations.Replace(q, {}) == Status::kOk);
    }
    for (const ConfigurationId q : again) {
      RC_ASSERT(observations.Replace(q, c.seen[q]) == Status::kOk);
    }
    RC_ASSERT(Chosen(c, observations) == chosen);
  }));
}

TEST_F(SetCoverTest, WeighsNoMoreThanTheBoundAllowsOverTheLeast) {
  EXPECT_TRUE(rc::check("H(d) times the least", [this] {
    const CoverCase c = AnyCover(11, 30, 3);
    double harmonic = 0;  // H(d)
    std::int64_t terms = 0;
    for (const ConfigurationId q : c.Offered()) {
      const auto d = std::count_if(c.seen[q].begin(), c.seen[q].end(),
                                   [&](PrimitiveId p) { return c.wanted[p] > 0; });
      while (terms < d) {
        harmonic += 1.0 / static_cast<double>(++terms);
      }
    }
    const double least = test::LeastWeight(c);
    const double weight = test::WeightOf(c, Chosen(c));
    RC_ASSERT(weight >= least - 1e-9);  // sums of hundredths
    RC_ASSERT(weight <= harmonic * least + 1e-9);
  }));
}

TEST_F(SetCoverTest, DropsALargeOneThatSmallerOnesTogetherReplace) {
  EXPECT_EQ(Chosen({.seen = {{1, 2, 3, 4}, {0, 1, 2}, {3, 4, 5}},
                    .wanted = {1, 1, 1, 1, 1, 1},
                    .candidates = {0, 1, 2}}),
            (Ids{1, 2}));
  EXPECT_EQ(cover_.dropped(), 1);
}

TEST_F(SetCoverTest, TakesTheLowestIdOfThoseThatGainTheSame) {
  EXPECT_EQ(Chosen({.seen = {{0}, {1, 2}, {1, 2}}, .wanted = {0, 1, 1}, .candidates = {2, 0, 1}}),
            Ids{1});
}

TEST_F(SetCoverTest, TakesAKeptOneFirstOfThoseThatGainTheSame) {
  EXPECT_EQ(Chosen({.seen = {{0, 1}, {0, 1}}, .wanted = {1, 1}, .candidates = {0}, .kept = {1}}),
            Ids{1});
}

TEST_F(SetCoverTest, DropsANewOneBeforeAKeptOneThatSeesAsMuch) {
  // Nobody but 0 and 1 sees 0; what else they see, 2 to 5 see as well, who are needed.
  const CoverCase c{
      .seen = {{0, 1, 2, 3, 4}, {0, 5, 6, 7, 8}, {1, 2, 9}, {3, 4, 10}, {5, 6, 11}, {7, 8, 12}},
      .wanted = std::vector<std::uint8_t>(13, 1),
      .candidates = {0, 2, 3, 4, 5},
      .kept = {1}};
  EXPECT_EQ(test::NaiveGreedy(c), (Ids{1, 0, 2, 3, 4, 5}));
  EXPECT_EQ(Chosen(c), (Ids{1, 2, 3, 4, 5}));
}

TEST_F(SetCoverTest, KeepsWhatOneNewOneCouldReplaceIfToldTo) {
  CoverCase c{.seen = {{0, 1, 2, 3}, {0, 1}, {2, 3}},
              .wanted = {1, 1, 1, 1},
              .candidates = {0},
              .kept = {1, 2}};
  EXPECT_EQ(Chosen(c), Ids{0});
  c.kept_percent = 199;
  EXPECT_EQ(Chosen(c), Ids{0});
  c.kept_percent = 200;
  EXPECT_EQ(Chosen(c), (Ids{1, 2}));
}

TEST_F(SetCoverTest, EvaluatesFarFewerThanAllEveryTime) {
  const CoverCase c = RandomCover(80, 120, 3, 5);
  const auto choices = std::ssize(Chosen(c)) + cover_.dropped();
  const auto offered = std::ssize(c.Offered());
  EXPECT_GT(choices, 15);
  EXPECT_GE(cover_.evaluations(), offered + choices);
  EXPECT_LT(cover_.evaluations(), offered * choices / 3);
}

}  // namespace
}  // namespace pipewright
