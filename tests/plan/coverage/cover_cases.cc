// SPDX-License-Identifier: MIT
#include "tests/plan/coverage/cover_cases.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <tuple>

#include "platform/core/rng.h"

namespace pipewright::test {

Observations CoverCase::Observed() const {
  int incidences = 0;
  for (const auto& list : seen) {
    incidences += static_cast<int>(list.size());
  }
  Observations observations({.configurations = static_cast<int>(seen.size()),
                             .primitives = static_cast<int>(wanted.size()),
                             .incidences = incidences});
  for (const auto& list : seen) {
    if (!observations.Add(list).ok()) {
      std::abort();  // a case that is wrong
    }
  }
  return observations;
}

std::vector<ConfigurationId> CoverCase::Offered() const {
  std::vector<ConfigurationId> all = candidates;
  all.insert(all.end(), kept.begin(), kept.end());
  return all;
}

bool CoverCase::IsKept(ConfigurationId q) const {
  return std::find(kept.begin(), kept.end(), q) != kept.end();
}

CoverCase RandomCover(int configurations, int primitives, int redundancy, std::uint64_t seed) {
  Rng rng(seed);
  CoverCase c;
  std::vector<double> x(primitives);
  std::vector<double> y(primitives);
  for (int p = 0; p < primitives; ++p) {
    x[p] = rng.Uniform();
    y[p] = rng.Uniform();
    c.wanted.push_back(static_cast<std::uint8_t>(rng.Index(redundancy + 1)));
  }
  for (ConfigurationId q = 0; q < configurations; ++q) {
    const double center_x = rng.Uniform();
    const double center_y = rng.Uniform();
    const double radius = rng.Uniform(0, 0.35);
    c.seen.emplace_back();
    for (PrimitiveId p = 0; p < primitives; ++p) {
      const double dx = x[p] - center_x;
      const double dy = y[p] - center_y;
      if (dx * dx + dy * dy < radius * radius) {
        c.seen.back().push_back(p);
      }
    }
    if (const int draw = rng.Index(8); draw > 0) {
      (draw > 5 ? c.kept : c.candidates).push_back(q);
    }
  }
  c.kept_percent = 100 + 50 * rng.Index(12);
  return c;
}

std::vector<int> TimesSeen(const CoverCase& c, const std::vector<ConfigurationId>& chosen) {
  std::vector<int> times(c.wanted.size());
  for (const ConfigurationId q : chosen) {
    for (const PrimitiveId p : c.seen[q]) {
      ++times[p];
    }
  }
  return times;
}

std::vector<Shortfall> MissingOf(const CoverCase& c) {
  const std::vector<int> times = TimesSeen(c, c.Offered());
  std::vector<Shortfall> missing;
  for (int p = 0; p < static_cast<int>(c.wanted.size()); ++p) {
    if (times[p] < c.wanted[p]) {
      missing.push_back({.primitive = p, .missing = c.wanted[p] - times[p]});
    }
  }
  return missing;
}

bool SeesAllThatCanBe(const CoverCase& c, const std::vector<ConfigurationId>& chosen) {
  const std::vector<int> times = TimesSeen(c, chosen);
  const std::vector<int> most = TimesSeen(c, c.Offered());
  for (std::size_t p = 0; p < c.wanted.size(); ++p) {
    if (times[p] < std::min<int>(c.wanted[p], most[p])) {
      return false;
    }
  }
  return true;
}

std::vector<ConfigurationId> NaiveGreedy(const CoverCase& c) {
  std::vector<ConfigurationId> chosen;
  std::vector<ConfigurationId> rest = c.Offered();
  std::sort(rest.begin(), rest.end());
  for (;;) {
    const std::vector<int> times = TimesSeen(c, chosen);
    int best_score = 0;
    bool best_kept = false;
    auto best = rest.end();
    for (auto q = rest.begin(); q != rest.end(); ++q) {
      int gain = 0;
      for (const PrimitiveId p : c.seen[*q]) {
        gain += times[p] < c.wanted[p];
      }
      const bool kept = c.IsKept(*q);
      const int score = gain * (kept ? c.kept_percent : 100);
      if (score > best_score || (score == best_score && score > 0 && kept && !best_kept)) {
        best_score = score;
        best_kept = kept;
        best = q;
      }
    }
    if (best == rest.end()) {
      return chosen;
    }
    chosen.push_back(*best);
    rest.erase(best);
  }
}

std::vector<ConfigurationId> NaivelyPruned(const CoverCase& c,
                                           std::vector<ConfigurationId> chosen) {
  std::vector<std::tuple<int, bool, ConfigurationId>> order;
  for (const ConfigurationId q : chosen) {
    const auto wanted = std::count_if(c.seen[q].begin(), c.seen[q].end(),
                                      [&](PrimitiveId p) { return c.wanted[p] > 0; });
    const bool kept = c.IsKept(q);
    order.emplace_back(static_cast<int>(wanted) * (kept ? c.kept_percent : 100), kept, -q);
  }
  std::sort(order.begin(), order.end());
  for (const auto& [score, kept, minus_q] : order) {
    std::vector<ConfigurationId> without = chosen;
    std::erase(without, -minus_q);
    if (SeesAllThatCanBe(c, without)) {
      chosen = without;
    }
  }
  return chosen;
}

double WeightOf(const CoverCase& c, const std::vector<ConfigurationId>& chosen) {
  double weight = 0;
  for (const ConfigurationId q : chosen) {
    weight += c.IsKept(q) ? 100.0 / c.kept_percent : 1;
  }
  return weight;
}

double LeastWeight(const CoverCase& c) {
  const std::vector<ConfigurationId> offered = c.Offered();
  double least = std::numeric_limits<double>::infinity();
  for (unsigned subset = 0; subset < 1U << offered.size(); ++subset) {
    std::vector<ConfigurationId> chosen;
    for (std::size_t k = 0; k < offered.size(); ++k) {
      if ((subset >> k & 1U) != 0) {
        chosen.push_back(offered[k]);
      }
    }
    const double weight = WeightOf(c, chosen);
    if (weight < least && SeesAllThatCanBe(c, chosen)) {
      least = weight;
    }
  }
  return least;
}

}  // namespace pipewright::test
