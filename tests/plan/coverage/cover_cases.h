// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "plan/coverage/set_cover.h"

namespace pipewright::test {

/// A problem that owns what it is of.
struct CoverCase {
  std::vector<std::vector<PrimitiveId>> seen;  ///< by configuration
  std::vector<std::uint8_t> wanted;
  std::vector<ConfigurationId> candidates;
  std::vector<ConfigurationId> kept = {};
  int kept_percent = 100;

  CoverProblem Problem() const {
    return {.wanted = wanted, .candidates = candidates, .kept = kept, .kept_percent = kept_percent};
  }
  Observations Observed() const;
  std::vector<ConfigurationId> Offered() const;
  bool IsKept(ConfigurationId q) const;
};

/// Disks that look at points in a square; each point is wanted up to `redundancy` times, some not
/// at all; some disks are kept, and one in eight is not offered.
CoverCase RandomCover(int configurations, int primitives, int redundancy, std::uint64_t seed);

/// How many of `chosen` see each primitive.
std::vector<int> TimesSeen(const CoverCase& c, const std::vector<ConfigurationId>& chosen);

/// What is missing of each primitive even if all are chosen that are offered.
std::vector<Shortfall> MissingOf(const CoverCase& c);

/// Whether each primitive is seen as often as wanted, or as all together see it.
bool SeesAllThatCanBe(const CoverCase& c, const std::vector<ConfigurationId>& chosen);

/// Greedy choice that evaluates all every time; nothing is pruned.
std::vector<ConfigurationId> NaiveGreedy(const CoverCase& c);

/// What is left of `chosen` when, one by one, those are dropped without which all that can be is
/// seen: whoever sees the fewest wanted primitives, by weight, first.
std::vector<ConfigurationId> NaivelyPruned(const CoverCase& c, std::vector<ConfigurationId> chosen);

/// Weight of a choice: 1 of each candidate, 100 / kept_percent of each that is kept.
double WeightOf(const CoverCase& c, const std::vector<ConfigurationId>& chosen);

/// The least weight of all subsets that see all that can be; up to some 16 configurations.
double LeastWeight(const CoverCase& c);

}  // namespace pipewright::test
