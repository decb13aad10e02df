// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plan/tour/tour_problem.h"
#include "platform/core/status.h"

namespace pipewright {

/// A way that was planned. Its path is the caller's, who finds it by the handle.
struct RealWay {
  float length = 0;
  std::int32_t handle = 0;

  bool operator==(const RealWay&) const = default;
};

/// What is known of the ways between goals, from each to each: a lower bound of its length, or that
/// it was planned and is so long, or that it was planned and there is none.
///
///   bound --SetReal()--> real --SetBound()--> bound --Block()--> blocked --SetBound()--> bound
///
/// It outlives the tours that are made of it: goals keep their indices, and a goal that is new, or
/// has moved, or whose surroundings have changed, has its own ways set back by SetBound(), no
/// others. Any number of problems, each over goals of its own, may share one. Where a way is as
/// long as its way back, one number serves both, and so does the handle: it is then of the path
/// from the lower index to the higher.
///
/// Lengths are in any one unit, [m] or [s]. All memory is taken at construction: 8.125 bytes a pair
/// (from, to), 2 MiB for 512 goals.
class GoalWays {
 public:
  static constexpr int kCapacityMax = 4096;
  static constexpr float kLengthMax = 1e8F;  ///< so that a tour's are within TourProblem::kCostMax

  /// For goals 0 to goal_capacity − 1, in [0, kCapacityMax]; every bound is 0. `symmetric`: every
  /// way is as long as its way back.
  GoalWays(int goal_capacity, bool symmetric);

  /// The way is no longer planned, and not shorter than this: 0 will always do.
  /// @returns kOutOfRange, without effect: no such goals, from = to, or a length not in
  ///   [0, kLengthMax]; the same below
  Status SetBound(int from, int to, float length);
  /// All ways of a goal from and to others, itself left out: bound(from, to) -> float. O(|others|)
  /// @returns kOutOfRange, with effect up to the first that is
  template <typename Bound>
  Status SetBounds(int goal, std::span<const TourNode> others, Bound bound);
  Status SetReal(int from, int to, const RealWay& way);
  Status Block(int from, int to);

  bool IsPlanned(int from, int to) const {
    const std::size_t k = Index(from, to);
    return (planned_[k / 64] >> k % 64 & 1) != 0;
  }
  bool IsBlocked(int from, int to) const { return Length(from, to) > kLengthMax; }
  /// A planned way's length, or else its bound; infinite where it is blocked.
  float Length(int from, int to) const { return ways_[Index(from, to)].length; }
  /// Of a way that is planned and not blocked.
  std::int32_t Handle(int from, int to) const {
    assert(IsPlanned(from, to) && !IsBlocked(from, to));
    return ways_[Index(from, to)].handle;
  }

  int capacity() const { return capacity_; }
  bool symmetric() const { return symmetric_; }
  std::size_t MemoryBytes() const;

 private:
  std::size_t Index(int from, int to) const {
    assert(IsWay(from, to));
    return static_cast<std::size_t>(from) * static_cast<std::size_t>(capacity_) +
           static_cast<std::size_t>(to);
  }
  bool IsWay(int from, int to) const {
    return 0 <= from && from < capacity_ && 0 <= to && to < capacity_ && from != to;
  }
  void Put(int from, int to, const RealWay& way, bool planned);

  int capacity_;
  bool symmetric_;
  std::vector<RealWay> ways_;           // row-major, from row to column
  std::vector<std::uint64_t> planned_;  // a bit each
};

template <typename Bound>
Status GoalWays::SetBounds(int goal, std::span<const TourNode> others, Bound bound) {
  for (const TourNode other : others) {
    if (other == goal) {
      continue;
    }
    Status status = SetBound(goal, other, bound(goal, other));
    if (status == Status::kOk && !symmetric_) {
      status = SetBound(other, goal, bound(other, goal));
    }
    if (status != Status::kOk) {
      return status;
    }
  }
  return Status::kOk;
}

}  // namespace pipewright
