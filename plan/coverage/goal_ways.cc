// SPDX-License-Identifier: MIT
#include "plan/coverage/goal_ways.h"

#include <limits>

namespace pipewright {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

bool IsLength(float length) { return 0 <= length && length <= GoalWays::kLengthMax; }

}  // namespace

GoalWays::GoalWays(int goal_capacity, bool symmetric)
    : capacity_(goal_capacity), symmetric_(symmetric) {
  assert(0 <= goal_capacity && goal_capacity <= kCapacityMax);
  const auto goals = static_cast<std::size_t>(goal_capacity);
  ways_.resize(goals * goals);
  planned_.resize((goals * goals + 63) / 64);
}

Status GoalWays::SetBound(int from, int to, float length) {
  if (!IsWay(from, to) || !IsLength(length)) {
    return Status::kOutOfRange;
  }
  Put(from, to, {.length = length}, false);
  return Status::kOk;
}

Status GoalWays::SetReal(int from, int to, const RealWay& way) {
  if (!IsWay(from, to) || !IsLength(way.length)) {
    return Status::kOutOfRange;
  }
  Put(from, to, way, true);
  return Status::kOk;
}

Status GoalWays::Block(int from, int to) {
  if (!IsWay(from, to)) {
    return Status::kOutOfRange;
  }
  Put(from, to, {.length = kInfinity}, true);
  return Status::kOk;
}

void GoalWays::Put(int from, int to, const RealWay& way, bool planned) {
  for (const std::size_t k : {Index(from, to), symmetric_ ? Index(to, from) : Index(from, to)}) {
    const std::uint64_t bit = std::uint64_t{1} << k % 64;
    ways_[k] = way;
    planned_[k / 64] = planned ? planned_[k / 64] | bit : planned_[k / 64] & ~bit;
  }
}

std::size_t GoalWays::MemoryBytes() const {
  return ways_.capacity() * sizeof(RealWay) + planned_.capacity() * sizeof(std::uint64_t);
}

}  // namespace pipewright
