// SPDX-License-Identifier: MIT
#include "hil/canlog/log_diff.h"

#include <algorithm>

namespace pipewright::hil {

std::int64_t LogDiff::Since(int which, const LogFrame& frame) const {
  return frame.stamp_ns - sides_[static_cast<std::size_t>(which)].first_ns;
}

void LogDiff::Compare(const LogFrame& first, const LogFrame& second, IdDiff& id) {
  if (!SameOnTheWire(first, second)) {
    id.first = FirstDifference{id.same, {first, second}};
    return;
  }
  ++id.same;
  if (first.stamped && second.stamped) {
    id.later.Add(Since(1, second) - Since(0, first));
  }
}

void LogDiff::Take(int which, const LogFrame& frame, IdDiff& id) {
  ++id.frames[static_cast<std::size_t>(which)];
  if (id.first || id.given_up) {
    return;
  }
  if (!id.pending.empty() && id.ahead != which) {
    const LogFrame other = id.pending.front();
    id.pending.pop_front();
    --pending_;
    Compare(which == 0 ? frame : other, which == 0 ? other : frame, id);
  } else if (sides_[static_cast<std::size_t>(1 - which)].ended) {
    id.first = FirstDifference{id.same, {}};
    id.first->frames[static_cast<std::size_t>(which)] = frame;
  } else if (pending_ < kMostPending) {
    id.ahead = which;
    id.pending.push_back(frame);
    ++pending_;
    return;
  } else {
    id.given_up = true;
  }
  if (id.first || id.given_up) {
    pending_ -= id.pending.size();
    id.pending.clear();
  }
}

void LogDiff::Add(int which, std::span<const LogFrame> frames) {
  Side& side = sides_[static_cast<std::size_t>(which)];
  for (const LogFrame& frame : frames) {
    if (frame.stamped && !side.begun) {
      side.begun = true;
      side.first_ns = frame.stamp_ns;
    }
    side.since_ns = frame.stamped ? Since(which, frame) : side.since_ns;
    ++side.frames;
    IdDiff* const id = ids_.Find({0, frame.error, frame.extended, frame.id});
    if (id != nullptr) {
      Take(which, frame, *id);
    } else {
      ++beyond_;
    }
  }
}

void LogDiff::End(int which) {
  sides_[static_cast<std::size_t>(which)].ended = true;
  // What waits of the other log waits for ever.
  for (Entry& entry : ids_.entries()) {
    IdDiff& id = entry.value;
    if (!id.pending.empty() && id.ahead != which) {
      id.first = FirstDifference{id.same, {}};
      id.first->frames[static_cast<std::size_t>(id.ahead)] = id.pending.front();
      pending_ -= id.pending.size();
      id.pending.clear();
    }
  }
}

int LogDiff::Behind() const {
  const auto& [first, second] = sides_;
  if (first.ended || second.ended) {
    return first.ended ? 1 : 0;
  }
  if (first.begun && second.begun && first.since_ns != second.since_ns) {
    return first.since_ns < second.since_ns ? 0 : 1;
  }
  return first.frames <= second.frames ? 0 : 1;
}

std::vector<const LogDiff::Entry*> LogDiff::Sorted() const {
  std::vector<const Entry*> sorted;
  for (const Entry& entry : ids_.entries()) {
    sorted.push_back(&entry);
  }
  std::sort(sorted.begin(), sorted.end(),
            [](const Entry* a, const Entry* b) { return a->key < b->key; });
  return sorted;
}

}  // namespace pipewright::hil
