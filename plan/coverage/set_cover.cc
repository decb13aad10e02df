// SPDX-License-Identifier: MIT
#include "plan/coverage/set_cover.h"

#include <algorithm>
#include <cassert>

namespace pipewright {
namespace {

constexpr int kIdBits = 24;
constexpr std::uint64_t kIdMask = (std::uint64_t{1} << kIdBits) - 1;
constexpr int kPercentMax = 10000;

static_assert(SetCover::kConfigurationsMax - 1 <= kIdMask);
static_assert(std::uint64_t{SetCover::kPrimitivesMax} * kPercentMax <= ~std::uint64_t{0} >>
              (kIdBits + 1));

}  // namespace

SetCover::SetCover(int configuration_capacity, int primitive_capacity)
    : configuration_capacity_(configuration_capacity),
      primitive_capacity_(primitive_capacity),
      roles_(configuration_capacity),
      open_(primitive_capacity) {
  assert(0 <= configuration_capacity && configuration_capacity <= kConfigurationsMax);
  assert(0 <= primitive_capacity && primitive_capacity <= kPrimitivesMax);
  keys_.reserve(configuration_capacity);
  chosen_.reserve(configuration_capacity);
  shortfalls_.reserve(primitive_capacity);
}

Status SetCover::Solve(const Observations& observations, const CoverProblem& problem) {
  keys_.clear();
  chosen_.clear();
  shortfalls_.clear();
  left_ = 0;
  dropped_ = 0;
  evaluations_ = 0;
  if (const Status status = Admit(observations, problem); status != Status::kOk) {
    return status;
  }
  Open(observations, problem);
  Choose(observations);
  Prune(observations, problem.wanted);
  return shortfalls_.empty() ? Status::kOk : Status::kInfeasible;
}

Status SetCover::Admit(const Observations& observations, const CoverProblem& problem) {
  if (observations.capacity().configurations > configuration_capacity_ ||
      observations.capacity().primitives > primitive_capacity_) {
    return Status::kFull;
  }
  if (std::ssize(problem.wanted) != observations.capacity().primitives) {
    return Status::kMalformed;
  }
  if (problem.kept_percent < 100 || problem.kept_percent > kPercentMax) {
    return Status::kOutOfRange;
  }
  kept_percent_ = problem.kept_percent;
  std::fill(roles_.begin(), roles_.end(), Role::kNone);
  const Status status = Enlist(observations, problem.candidates, Role::kCandidate);
  return status == Status::kOk ? Enlist(observations, problem.kept, Role::kKept) : status;
}

Status SetCover::Enlist(const Observations& observations, std::span<const ConfigurationId> ids,
                        Role role) {
  for (const ConfigurationId q : ids) {
    if (!observations.Contains(q)) {
      return Status::kOutOfRange;
    }
    if (roles_[q] != Role::kNone) {
      return Status::kMalformed;
    }
    roles_[q] = role;
  }
  return Status::kOk;
}

SetCover::Key SetCover::KeyOf(ConfigurationId q, int count) const {
  const bool kept = roles_[q] == Role::kKept;
  const auto score = static_cast<Key>(count) * static_cast<Key>(kept ? kept_percent_ : 100);
  return (score << (kIdBits + 1)) | (Key{kept} << kIdBits) | (kIdMask - static_cast<Key>(q));
}

ConfigurationId SetCover::IdOf(Key key) {
  return static_cast<ConfigurationId>(kIdMask - (key & kIdMask));
}

void SetCover::Open(const Observations& observations, const CoverProblem& problem) {
  std::fill(open_.begin(), open_.end(), 0);
  for (const auto offered : {problem.candidates, problem.kept}) {
    for (const ConfigurationId q : offered) {
      for (const PrimitiveId p : observations.SeenBy(q)) {
        ++open_[p];
      }
    }
  }
  for (PrimitiveId p = 0; p < std::ssize(problem.wanted); ++p) {
    const int wanted = problem.wanted[p];
    if (open_[p] < wanted) {
      shortfalls_.push_back({.primitive = p, .missing = wanted - open_[p]});
    }
    open_[p] = std::min(open_[p], wanted);
    left_ += open_[p];
  }
  for (const auto offered : {problem.candidates, problem.kept}) {
    for (const ConfigurationId q : offered) {
      if (const int gain = Gain(observations, q); gain > 0) {
        keys_.push_back(KeyOf(q, gain));
      }
    }
  }
}

int SetCover::Gain(const Observations& observations, ConfigurationId q) {
  ++evaluations_;
  int gain = 0;
  for (const PrimitiveId p : observations.SeenBy(q)) {
    gain += open_[p] > 0;
  }
  return gain;
}

void SetCover::Choose(const Observations& observations) {
  std::make_heap(keys_.begin(), keys_.end());
  while (left_ > 0) {  // then some q sees what is open, for no more is open than can be seen
    std::pop_heap(keys_.begin(), keys_.end());
    const ConfigurationId q = IdOf(keys_.back());
    keys_.back() = KeyOf(q, Gain(observations, q));
    if (keys_.back() >= keys_.front()) {  // alone, it is both
      keys_.pop_back();
      Take(observations, q);
    } else {
      std::push_heap(keys_.begin(), keys_.end());
    }
  }
}

void SetCover::Take(const Observations& observations, ConfigurationId q) {
  chosen_.push_back(q);
  for (const PrimitiveId p : observations.SeenBy(q)) {
    left_ -= open_[p] > 0;
    --open_[p];
  }
}

void SetCover::Prune(const Observations& observations, std::span<const std::uint8_t> wanted) {
  keys_.clear();
  for (const ConfigurationId q : chosen_) {
    int count = 0;
    for (const PrimitiveId p : observations.SeenBy(q)) {
      count += wanted[p] > 0;
    }
    keys_.push_back(KeyOf(q, count));
  }
  std::sort(keys_.begin(), keys_.end());
  for (const Key key : keys_) {
    const ConfigurationId q = IdOf(key);
    if (!IsNeeded(observations, q)) {
      roles_[q] = Role::kDropped;
      for (const PrimitiveId p : observations.SeenBy(q)) {
        ++open_[p];
      }
    }
  }
  dropped_ = static_cast<int>(
      std::erase_if(chosen_, [&](ConfigurationId q) { return roles_[q] == Role::kDropped; }));
}

// Of what q sees, whatever is not wanted has at least q itself to spare.
bool SetCover::IsNeeded(const Observations& observations, ConfigurationId q) const {
  for (const PrimitiveId p : observations.SeenBy(q)) {
    if (open_[p] == 0) {
      return true;
    }
  }
  return false;
}

std::size_t SetCover::MemoryBytes() const {
  return roles_.capacity() * sizeof(Role) + open_.capacity() * sizeof(std::int32_t) +
         keys_.capacity() * sizeof(Key) + chosen_.capacity() * sizeof(ConfigurationId) +
         shortfalls_.capacity() * sizeof(Shortfall);
}

}  // namespace pipewright
