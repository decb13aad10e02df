// SPDX-License-Identifier: MIT
#include "plan/tour/assignment.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace pipewright {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

}  // namespace

Assignment::Assignment(int node_capacity)
    : u_(node_capacity),
      v_(node_capacity),
      distance_(node_capacity),
      column_of_(node_capacity),
      row_of_(node_capacity),
      free_rows_(node_capacity),
      predecessor_(node_capacity),
      columns_(node_capacity) {}

void Assignment::Solve(const CostTable& costs, TourClock& clock) {
  n_ = costs.size();
  ReduceColumns(costs);
  ReduceRows(costs);
  ReduceRows(costs);
  for (; free_count_ > 0 && !clock.LateNow(); --free_count_) {
    Augment(costs, free_rows_[free_count_ - 1]);
  }
  SetRowDuals(costs);
  if (costs.symmetric()) {  // then (v, u) is feasible as well, and so is the mean
    for (int i = 0; i < n_; ++i) {
      u_[i] = v_[i] = (u_[i] + v_[i]) / 2;
    }
  }
}

/// v(j) ← the least cost in column j, and its row takes the column if it has none.
void Assignment::ReduceColumns(const CostTable& costs) {
  std::fill_n(v_.begin(), n_, kInfinity);
  for (int i = 0; i < n_; ++i) {
    const float* row = costs.Row(i);
    for (int j = 0; j < n_; ++j) {
      if (row[j] < v_[j]) {
        v_[j] = row[j];
        row_of_[j] = static_cast<TourNode>(i);
      }
    }
  }
  std::fill_n(column_of_.begin(), n_, kNone);
  for (int j = 0; j < n_; ++j) {
    TourNode& column = column_of_[row_of_[j]];
    if (column == kNone) {
      column = static_cast<TourNode>(j);
    } else {
      row_of_[j] = kNone;
    }
  }
  free_count_ = 0;
  for (int i = 0; i < n_; ++i) {
    if (column_of_[i] == kNone) {
      free_rows_[free_count_++] = static_cast<TourNode>(i);
    }
  }
}

/// Each free row takes its cheapest column, which becomes dearer by the lead it has over the
/// second; the row that had it is free next. [Jonker, Volgenant], augmenting row reduction.
void Assignment::ReduceRows(const CostTable& costs) {
  int left = 0;        // rows that stay free, at the front of free_rows_
  int moves = 4 * n_;  // a bound: equal leads can hand two columns round for long
  for (int k = 0; k < free_count_;) {
    const TourNode i = free_rows_[k++];
    const float* row = costs.Row(i);
    float first = kInfinity;
    float second = kInfinity;
    TourNode j1 = kNone;
    TourNode j2 = kNone;
    for (int j = 0; j < n_; ++j) {
      const float reduced = row[j] - v_[j];
      if (reduced < first) {
        second = std::exchange(first, reduced);
        j2 = std::exchange(j1, static_cast<TourNode>(j));
      } else if (reduced < second) {
        second = reduced;
        j2 = static_cast<TourNode>(j);
      }
    }
    const bool leads = first < second && v_[j1] - (second - first) < v_[j1];
    if (leads) {
      v_[j1] -= second - first;
    } else if (row_of_[j1] != kNone) {
      j1 = j2;
    }
    const TourNode displaced = std::exchange(row_of_[j1], i);
    column_of_[i] = j1;
    if (displaced != kNone) {
      column_of_[displaced] = kNone;
      if (leads && --moves > 0) {
        free_rows_[--k] = displaced;
      } else {
        free_rows_[left++] = displaced;
      }
    }
  }
  free_count_ = left;
}

/// Dijkstra from the row over alternating paths of reduced costs. @returns the free column reached
TourNode Assignment::SettleUntilFree(const CostTable& costs, TourNode row) {
  std::fill_n(distance_.begin(), n_, kInfinity);
  std::iota(columns_.begin(), columns_.begin() + n_, TourNode{0});
  TourNode from = row;
  float offset = 0;
  for (settled_ = 0;;) {
    const float* c = costs.Row(from);
    int nearest = settled_;
    float least = kInfinity;
    for (int k = settled_; k < n_; ++k) {
      const TourNode j = columns_[k];
      const float through = c[j] - v_[j] + offset;
      if (through < distance_[j]) {
        distance_[j] = through;
        predecessor_[j] = from;
      }
      if (distance_[j] < least || (distance_[j] == least && row_of_[j] == kNone)) {
        least = distance_[j];
        nearest = k;
      }
    }
    std::swap(columns_[nearest], columns_[settled_]);
    const TourNode j = columns_[settled_++];
    if (row_of_[j] == kNone) {
      return j;
    }
    from = row_of_[j];
    offset = least - (costs(from, j) - v_[j]);
  }
}

void Assignment::Augment(const CostTable& costs, TourNode row) {
  TourNode j = SettleUntilFree(costs, row);
  const float length = distance_[j];
  for (int k = 0; k < settled_; ++k) {
    v_[columns_[k]] -= length - distance_[columns_[k]];
  }
  for (TourNode i = kNone; i != row;) {
    i = predecessor_[j];
    row_of_[j] = i;
    j = std::exchange(column_of_[i], j);
  }
}

/// u(i) ← the most that v allows.
void Assignment::SetRowDuals(const CostTable& costs) {
  for (int i = 0; i < n_; ++i) {
    const float* row = costs.Row(i);
    u_[i] = kInfinity;
    for (int j = 0; j < n_; ++j) {
      u_[i] = std::min(u_[i], row[j] - v_[j]);
    }
  }
}

double Assignment::Bound() const {
  return std::accumulate(u_.begin(), u_.begin() + n_, 0.0) +
         std::accumulate(v_.begin(), v_.begin() + n_, 0.0);
}

std::span<const TourNode> Assignment::next() const {
  return {column_of_.data(), free_count_ == 0 ? static_cast<std::size_t>(n_) : 0};
}

std::size_t Assignment::MemoryBytes() const {
  return 3 * u_.capacity() * sizeof(float) + 5 * row_of_.capacity() * sizeof(TourNode);
}

}  // namespace pipewright
