// SPDX-License-Identifier: MIT
#include "hil/replay/recorded_bus.h"

#include <fmt/format.h>

namespace pipewright::hil {

void RecordedBus::Read() {
  const auto take = [this](const LogFrame& frame) { sorted_.push_back(frame); };
  const std::span<const LogFrame> frames = log_.Next();
  for (const LogFrame& frame : frames) {
    if (frame.fd || !frame.stamped || frame.stamp_ns < 0) {
      ++passed_over_;
    } else {
      sorter_.Add(frame, take);
    }
  }
  if (frames.empty()) {
    read_all_ = true;
    sorter_.End(take);
  }
}

std::string RecordedBus::Open() {
  const bool any = HasNext();
  if (!log_.error().empty()) {
    return log_.error();
  }
  if (!any && passed_over_ > 0) {
    return fmt::format("{}: none of its {} frames is of classic CAN and has a time",
                       log_.files().front().path, passed_over_);
  }
  return "";
}

void RecordedBus::ReadToEnd() {
  while (!read_all_) {
    Read();
  }
  if (ended_) {
    beyond_silence_ += sorted_.size();
    sorted_.clear();
  }
}

bool RecordedBus::HasNext() {
  while (!next_ && !ended_) {
    if (sorted_.empty() && !read_all_) {
      Read();
      continue;
    }
    if (sorted_.empty()) {
      ended_ = true;
      break;
    }
    LogFrame frame = sorted_.front();
    sorted_.pop_front();
    if (!begun_) {
      begun_ = true;
      zero_ns_ = frame.stamp_ns >= kCalendar.time_since_epoch().count() ? frame.stamp_ns : 0;
      last_ns_ = frame.stamp_ns - zero_ns_;
    }
    frame.stamp_ns -= zero_ns_;
    if (frame.stamp_ns < last_ns_) {
      ++passed_over_;
    } else if (frame.stamp_ns - last_ns_ > kLongestSilence.count()) {
      ended_ = true;
      ++beyond_silence_;
    } else {
      last_ns_ = frame.stamp_ns;
      next_ = frame;
    }
  }
  return next_.has_value();
}

void RecordedBus::AdvanceTo(Time now) {
  now_ = now;
  while (HasNext() && next_->stamp_ns <= now.time_since_epoch().count()) {
    if (IsCommand(*next_)) {
      ++commands_;
      comparison_.Recorded(*next_);
    } else {
      ++states_;
      heard_.push_back(ClassicFrame(*next_));
    }
    next_.reset();
  }
}

Status RecordedBus::Send(const can::Frame& frame) {
  comparison_.Replayed(frame, now_);
  return Status::kOk;
}

bool RecordedBus::Receive(can::Frame& frame) {
  if (heard_.empty()) {
    return false;
  }
  frame = heard_.front();
  heard_.pop_front();
  return true;
}

}  // namespace pipewright::hil
