// SPDX-License-Identifier: MIT
#include "hil/faults/faulty_port.h"

#include <algorithm>
#include <utility>

namespace pipewright::hil {

Status FaultyPort::Send(const can::Frame& frame) {
  const Status status = down_ ? Status::kUnavailable : send_;
  if (status != Status::kOk) {
    ++counters_.tx_refused;
    return status;
  }
  return inner_.Send(frame);
}

bool FaultyPort::Receive(can::Frame& frame) {
  if (queue_.empty()) {
    return false;
  }
  frame = queue_.front();
  queue_.pop_front();
  return true;
}

void FaultyPort::AdvanceTo(Time now) {
  can::Frame frame;
  while (inner_.Receive(frame)) {
    if (down_) {
      ++counters_.lost;
      continue;
    }
    frame.stamp += stamp_offset_;
    memory_.push_back(frame);
    if (memory_.size() > kRemembered) {
      memory_.pop_front();
    }
    Take(frame, now);
  }
  const auto due =
      std::stable_partition(late_.begin(), late_.end(), [&](const Late& l) { return l.due > now; });
  std::for_each(due, late_.end(), [&](const Late& l) { Push(l.frame); });
  late_.erase(due, late_.end());
  for (can::Frame& inserted : inserted_) {
    inserted.stamp = now + stamp_offset_;
    Push(inserted);
    ++counters_.inserted;
  }
  inserted_.clear();
}

void FaultyPort::Take(const can::Frame& frame, Time now) {
  const auto rule =
      std::find_if(rules_.begin(), rules_.end(), [&](const Rule& r) { return r.match(frame); });
  if (rule != rules_.end()) {
    switch (rule->kind) {
      case Kind::kLose:
        ++counters_.lost;
        break;
      case Kind::kDuplicate:
        ++counters_.duplicated;
        Push(frame);
        Push(frame);
        break;
      case Kind::kDelay:
        ++counters_.delayed;
        late_.push_back({now + rule->by, frame});
        break;
      case Kind::kSwap:
        swapped_ = frame;
        break;
    }
    if (--rule->left == 0) {
      rules_.erase(rule);
    }
    return;
  }
  Push(frame);
  if (swapped_ && swapped_->id == frame.id) {
    ++counters_.swapped;
    Push(*swapped_);
    swapped_.reset();
  }
}

void FaultyPort::Push(const can::Frame& frame) {
  if (queue_.size() == kRxCapacity) {
    ++counters_.rx_dropped;
    return;
  }
  queue_.push_back(frame);
}

void FaultyPort::Lose(int frames, FrameMatch match) {
  rules_.push_back({Kind::kLose, frames, std::move(match)});
}

void FaultyPort::Duplicate(int frames, FrameMatch match) {
  rules_.push_back({Kind::kDuplicate, frames, std::move(match)});
}

void FaultyPort::Delay(int frames, Duration by, FrameMatch match) {
  rules_.push_back({Kind::kDelay, frames, std::move(match), by});
}

void FaultyPort::Swap(FrameMatch match) { rules_.push_back({Kind::kSwap, 1, std::move(match)}); }

void FaultyPort::Insert(const can::Frame& frame) { inserted_.push_back(frame); }

bool FaultyPort::Replay(Rng& rng) {
  if (memory_.empty()) {
    return false;
  }
  Insert(memory_[static_cast<std::size_t>(rng.Index(static_cast<int>(memory_.size())))]);
  return true;
}

}  // namespace pipewright::hil
