// SPDX-License-Identifier: MIT
#include "plan/coverage/observations.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <map>
#include <numeric>
#include <vector>

#include "tests/support/no_alloc_scope.h"

namespace pipewright {
namespace {

const bool kSeeded = setenv("RC_PARAMS", "seed=20261124 max_success=2000", 0) == 0;

using Ids = std::vector<std::int32_t>;

Ids SeenBy(const Observations& o, ConfigurationId q) {
  Ids seen;
  for (const PrimitiveId p : o.SeenBy(q)) {
    seen.push_back(p);
  }
  return seen;
}

Ids ObserversOf(const Observations& o, PrimitiveId p) {
  Ids observers;
  for (const ConfigurationId q : o.ObserversOf(p)) {
    observers.push_back(q);
  }
  return observers;
}

/// The ids first, first + step, ...; `count` of them.
Ids Every(int step, int count, int first = 0) {
  Ids ids(count);
  for (int k = 0; k < count; ++k) {
    ids[k] = first + k * step;
  }
  return ids;
}

/// The oracle: the set system as a map, and its capacities.
class Model {
 public:
  explicit Model(const ObservationCapacity& capacity) : capacity_(capacity) {}

  bool Has(ConfigurationId q) const { return seen_.contains(q); }
  int Incidences() const {
    return std::accumulate(seen_.begin(), seen_.end(), 0, [](int sum, const auto& entry) {
      return sum + static_cast<int>(entry.second.size());
    });
  }
  /// How adding ends, or replacing what q sees.
  Status Ends(const Ids& seen, const ConfigurationId* q) const {
    if (q != nullptr && !Has(*q)) {
      return Status::kOutOfRange;
    }
    const auto bad = [&](int p) { return p < 0 || p >= capacity_.primitives; };
    if (std::any_of(seen.begin(), seen.end(), bad)) {
      return Status::kOutOfRange;
    }
    if (std::adjacent_find(seen.begin(), seen.end(), std::greater_equal<>()) != seen.end()) {
      return Status::kMalformed;
    }
    const auto before = q != nullptr ? std::ssize(seen_.at(*q)) : 0;
    const bool no_id = q == nullptr && std::ssize(seen_) == capacity_.configurations;
    return no_id || Incidences() - before + std::ssize(seen) > capacity_.incidences ? Status::kFull
                                                                                    : Status::kOk;
  }
  void Put(ConfigurationId q, const Ids& seen) { seen_[q] = seen; }
  void Erase(ConfigurationId q) { seen_.erase(q); }

  void RequireSame(const Observations& o) const {
    RC_ASSERT(o.configurations() == std::ssize(seen_));
    RC_ASSERT(o.incidences() == Incidences());
    for (ConfigurationId q = -1; q <= capacity_.configurations; ++q) {
      RC_ASSERT(o.Contains(q) == Has(q));
    }
    std::map<PrimitiveId, Ids> observers;
    for (const auto& [q, seen] : seen_) {
      RC_ASSERT(SeenBy(o, q) == seen);
      RC_ASSERT(o.SeenCount(q) == std::ssize(seen));
      for (const PrimitiveId p : seen) {
        observers[p].push_back(q);
      }
    }
    for (PrimitiveId p = 0; p < capacity_.primitives; ++p) {
      Ids found = ObserversOf(o, p);
      std::sort(found.begin(), found.end());
      RC_ASSERT(found == observers[p]);
      RC_ASSERT(o.ObserverCount(p) == std::ssize(found));
    }
  }

 private:
  ObservationCapacity capacity_;
  std::map<ConfigurationId, Ids> seen_;
};

enum class Fault : std::uint8_t { kNone, kBelow, kAbove, kTwice, kBackwards };

/// Lists of all lengths, those of whole pages and nearly so among them; some that are wrong.
Ids AnyList(int primitives) {
  const int one_in = *rc::gen::inRange(1, 5);
  Ids list;
  for (PrimitiveId p = 0; p < primitives; ++p) {
    if (*rc::gen::inRange(0, one_in) == 0) {
      list.push_back(p);
    }
  }
  list.resize(std::min<std::size_t>(list.size(), *rc::gen::element(0, 1, 31, 32, 33, 64, 99)));
  switch (*rc::gen::weightedElement<Fault>({{8, Fault::kNone},
                                            {1, Fault::kBelow},
                                            {1, Fault::kAbove},
                                            {1, Fault::kTwice},
                                            {1, Fault::kBackwards}})) {
    case Fault::kNone:
      break;
    case Fault::kBelow:
      list.insert(list.begin(), -1);
      break;
    case Fault::kAbove:
      list.push_back(primitives);
      break;
    case Fault::kTwice:
      list.insert(list.begin(), 3, 0);
      break;
    case Fault::kBackwards:
      std::reverse(list.begin(), list.end());
      break;
  }
  return list;
}

TEST(Observations, HoldWhatAMapHoldsWhateverIsDone) {
  EXPECT_TRUE(kSeeded);
  EXPECT_TRUE(rc::check("equal to a map", [] {
    const ObservationCapacity capacity{.configurations = 5, .primitives = 70, .incidences = 150};
    Observations o(capacity);
    Model model(capacity);
    const int steps = *rc::gen::inRange(1, 40);
    for (int step = 0; step < steps; ++step) {
      const ConfigurationId q = *rc::gen::inRange(-1, capacity.configurations + 1);
      const Ids list = AnyList(capacity.primitives);
      switch (*rc::gen::inRange(0, 4)) {
        case 0: {
          const bool there = model.Has(q);
          RC_ASSERT(o.Remove(q) == (there ? Status::kOk : Status::kOutOfRange));
          model.Erase(q);
          break;
        }
        case 1: {
          const Status expected = model.Ends(list, &q);
          RC_ASSERT(o.Replace(q, list) == expected);
          if (expected == Status::kOk) {
            model.Put(q, list);
          }
          break;
        }
        default: {
          const Status expected = model.Ends(list, nullptr);
          const Result<ConfigurationId> added = o.Add(list);
          RC_ASSERT(added.status() == expected);
          if (expected == Status::kOk) {
            RC_ASSERT(!model.Has(*added));
            model.Put(*added, list);
          }
        }
      }
      model.RequireSame(o);
    }
  }));
}

TEST(Observations, TakeListsThatFillTheirPagesWorst) {
  Observations o({.configurations = 3, .primitives = 99, .incidences = 99});
  for (int round = 0; round < 3; ++round) {  // whatever was there before
    for (int k = 0; k < 3; ++k) {
      ASSERT_TRUE(o.Add(Every(3, 33, k)).ok());
    }
    EXPECT_EQ(o.incidences(), 99);
    for (const ConfigurationId q : {1, 0, 2}) {
      ASSERT_EQ(o.Remove(q), Status::kOk);
    }
  }
  EXPECT_TRUE(o.Add(Every(1, 99)).ok());
}

TEST(Observations, RefuseWhenFullAndKeepWhatTheyHave) {
  Observations o({.configurations = 2, .primitives = 40, .incidences = 40});
  const Ids evens = Every(2, 20);
  const ConfigurationId a = *o.Add(evens);
  EXPECT_EQ(o.Add(Every(1, 21)).status(), Status::kFull);
  EXPECT_EQ(o.configurations(), 1);
  const ConfigurationId b = *o.Add(Every(1, 20));
  EXPECT_EQ(o.Add({}).status(), Status::kFull);
  EXPECT_EQ(o.Replace(b, Every(1, 21)), Status::kFull);
  EXPECT_EQ(SeenBy(o, a), evens);
  EXPECT_EQ(SeenBy(o, b), Every(1, 20));
  EXPECT_EQ(o.Replace(a, {}), Status::kOk);
  EXPECT_EQ(o.Replace(b, Every(1, 40)), Status::kOk);
  EXPECT_EQ(ObserversOf(o, 39), Ids{b});
}

TEST(Observations, GiveAnIdAgainOnceItIsFree) {
  Observations o({.configurations = 3, .primitives = 4, .incidences = 12});
  EXPECT_EQ(*o.Add(Ids{0}), 0);
  EXPECT_EQ(*o.Add(Ids{1}), 1);
  EXPECT_EQ(*o.Add(Ids{2}), 2);
  EXPECT_EQ(o.Remove(1), Status::kOk);
  EXPECT_EQ(o.Remove(1), Status::kOutOfRange);
  EXPECT_EQ(*o.Add(Ids{3}), 1);
  EXPECT_EQ(SeenBy(o, 1), Ids{3});
  EXPECT_EQ(SeenBy(o, 2), Ids{2});
}

TEST(Observations, WithoutAnyCapacityRefuseAll) {
  Observations o({});
  EXPECT_EQ(o.Add({}).status(), Status::kFull);
  EXPECT_EQ(o.Add(Ids{0}).status(), Status::kOutOfRange);
  EXPECT_EQ(o.Replace(0, {}), Status::kOutOfRange);
  EXPECT_EQ(o.Remove(0), Status::kOutOfRange);
}

TEST(Observations, TakeNothingFromTheHeap) {
  Observations o({.configurations = 100, .primitives = 1000, .incidences = 20000});
  const Ids few = Every(7, 100);
  const Ids many = Every(3, 300);
  const test::NoAllocScope no_alloc;
  for (int k = 0; k < 60; ++k) {
    EXPECT_TRUE(o.Add(many).ok());
  }
  for (ConfigurationId q = 0; q < 60; q += 2) {
    EXPECT_EQ(o.Replace(q, few), Status::kOk);
    EXPECT_EQ(o.Remove(q + 1), Status::kOk);
  }
  EXPECT_EQ(o.incidences(), 30 * 100);
}

TEST(Observations, TakeTheMemoryThatTheySay) {
  const ObservationCapacity plan{
      .configurations = 5000, .primitives = 100'000, .incidences = 2'000'000};
  const double bytes = 12.25 * plan.incidences + 390.0 * plan.configurations + 8 * plan.primitives;
  EXPECT_NEAR(static_cast<double>(Observations(plan).MemoryBytes()), bytes, 0.01 * bytes);
}

}  // namespace
}  // namespace pipewright
