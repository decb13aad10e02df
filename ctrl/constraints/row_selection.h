// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <limits>

#include "ctrl/constraints/svfi.h"

namespace pipewright {

/// The box lb ≤ u ≤ ub, 0 in it, that a cycle's u comes from, and the z of its chance rows.
struct ControlBox {
  const Controls& lb;
  const Controls& ub;
  double z = 0;
};

/// The part t of the box in which a row cannot be broken: with f(u) = a'u + z σ_f(u), convex, and
/// M ≥ f over the box,
///
///   f(t u) ≤ (1 − t) f(0) + t M ≤ limit    for    t ≤ (limit − f(0)) / (M − f(0))
///
/// 1 and more: no u of the box breaks it. Negative: u = 0 does, as it may a soft row.
double HeldPart(const Row& row, const ControlBox& box);
double HeldPart(const ChanceRow& row, const ControlBox& box);

/// Fills a list of rows of which more may come than there is room for, and then keeps those that
/// hold in the least part of the box. What is not in the list holds in `held` of the box: no other
/// choice makes that more. Counts nothing until the list is full.
template <typename R, int kCapacity>
class RowSelection {
 public:
  RowSelection(FixedVector<R, kCapacity>& rows, const ControlBox& box) : rows_(rows), box_(box) {}

  void Add(const R& row) {
    if (rows_.push_back(row)) {
      return;
    }
    if (dropped_++ == 0) {
      for (int i = 0; i < kCapacity; ++i) {
        heap_[i] = {HeldPart(rows_[i], box_), i};
      }
      std::make_heap(heap_.begin(), heap_.end(), kLess);
    }
    const double part = HeldPart(row, box_);
    held_ = std::min(held_, std::max(part, heap_.front().part));
    if (part >= heap_.front().part) {
      return;
    }
    std::pop_heap(heap_.begin(), heap_.end(), kLess);
    rows_[heap_.back().place] = row;
    heap_.back().part = part;
    std::push_heap(heap_.begin(), heap_.end(), kLess);
  }

  int dropped() const { return dropped_; }
  /// The part of the box in which every dropped row holds; infinite when none was.
  double held() const { return held_; }

 private:
  struct Entry {
    double part = 0;
    int place = 0;
  };
  static constexpr auto kLess = [](const Entry& a, const Entry& b) { return a.part < b.part; };

  FixedVector<R, kCapacity>& rows_;
  const ControlBox box_;
  std::array<Entry, kCapacity> heap_{};  ///< the row that holds in most of the box on top
  int dropped_ = 0;
  double held_ = std::numeric_limits<double>::infinity();
};

}  // namespace pipewright
