// SPDX-License-Identifier: MIT
#include "hil/replay/command_comparison.h"

#include <algorithm>
#include <tuple>

#include "hil/canlog/frame_rows.h"

namespace pipewright::hil {
namespace {

constexpr int kBaseRows = static_cast<int>(std::tuple_size_v<decltype(can::kTracerTable)>);

/// 0: the base, 1: the arm.
std::size_t DeviceOf(const LogFrame& frame) {
  const int row = RowOf(frame);
  return 0 <= row && row < kBaseRows ? 0 : 1;
}

LogFrame AsLogged(const can::Frame& from, Time now) {
  LogFrame frame;
  frame.stamp_ns = now.time_since_epoch().count();
  frame.stamped = true;
  frame.id = from.id;
  frame.length = from.dlc;
  frame.extended = from.extended;
  frame.remote = from.remote;
  frame.error = from.error;
  frame.direction = LogDirection::kSent;
  std::copy(from.data.begin(), from.data.end(), frame.data.begin());
  return frame;
}

IdKey KeyWithoutChannel(const LogFrame& frame) {
  IdKey key = KeyOf(frame);
  key.channel = 0;
  return key;
}

}  // namespace

bool IsCommand(const LogFrame& frame) {
  const int row = RowOf(frame);
  if (row < 0) {
    return false;
  }
  const can::FrameHead& head = kLogHeads[static_cast<std::size_t>(row)];
  return head.direction == can::Direction::kToDevice ||
         frame.id == can::kHeartbeat.head.id + can::kHostNode;
}

CommandCounts& CommandComparison::CountsOf(const IdKey& key) {
  return *counts_.Find(key);  // the tables have fewer ids than there is room for
}

std::deque<CommandComparison::Sent>& CommandComparison::WaitingOf(const IdKey& key) {
  const auto found = std::find_if(waiting_.begin(), waiting_.end(),
                                  [&key](const Waiting& one) { return one.key == key; });
  return found != waiting_.end() ? found->frames : waiting_.emplace_back(Waiting{key, {}}).frames;
}

void CommandComparison::Differ(const CommandDifference& difference) {
  if (!first_ || difference.at() < first_->at()) {
    first_ = difference;
  }
}

void CommandComparison::NotRecorded(const IdKey& key, const LogFrame& frame) {
  ++CountsOf(key).not_recorded;
  ++total_.not_recorded;
  Differ({std::nullopt, frame});
}

void CommandComparison::Meet(const LogFrame& recorded, const Sent& sent) {
  const std::size_t device = DeviceOf(recorded);
  met_[device] = std::max(met_[device], sent.number);
  CommandCounts& counts = CountsOf(KeyWithoutChannel(recorded));
  if (SameOnTheWire(recorded, sent.frame)) {
    ++counts.same;
    ++total_.same;
    return;
  }
  ++counts.different;
  ++total_.different;
  Differ({recorded, sent.frame});
}

void CommandComparison::Replayed(const can::Frame& from, Time now) {
  const LogFrame frame = AsLogged(from, now);
  const IdKey key = KeyWithoutChannel(frame);
  std::deque<Sent>& waiting = WaitingOf(key);
  while (!waiting.empty() && now - Time(Duration(waiting.front().frame.stamp_ns)) > kLongestWait) {
    NotRecorded(key, waiting.front().frame);
    waiting.pop_front();
  }
  waiting.push_back({frame, ++sent_[DeviceOf(frame)]});
}

void CommandComparison::Recorded(const LogFrame& frame) {
  const IdKey key = KeyWithoutChannel(frame);
  std::deque<Sent>& waiting = WaitingOf(key);
  const auto sent_before = [&](std::size_t i) {
    return i < waiting.size() && waiting[i].frame.stamp_ns < frame.stamp_ns;
  };
  if (!sent_before(0)) {
    ++CountsOf(key).not_replayed;
    ++total_.not_replayed;
    Differ({frame, std::nullopt});
    return;
  }
  if (!SameOnTheWire(frame, waiting[0].frame) && sent_before(1) &&
      SameOnTheWire(frame, waiting[1].frame)) {
    NotRecorded(key, waiting.front().frame);
    waiting.pop_front();
  }
  Meet(frame, waiting.front());
  waiting.pop_front();
}

void CommandComparison::End(Time end) {
  for (Waiting& one : waiting_) {
    for (const Sent& sent : one.frames) {
      const bool long_ago = end - Time(Duration(sent.frame.stamp_ns)) > kLongestWait;
      if (long_ago || sent.number < met_[DeviceOf(sent.frame)]) {
        NotRecorded(one.key, sent.frame);
      }
    }
    one.frames.clear();
  }
}

std::vector<const CommandComparison::Entry*> CommandComparison::Sorted() const {
  std::vector<const Entry*> sorted;
  for (const Entry& entry : counts_.entries()) {
    sorted.push_back(&entry);
  }
  std::sort(sorted.begin(), sorted.end(),
            [](const Entry* a, const Entry* b) { return a->key < b->key; });
  return sorted;
}

}  // namespace pipewright::hil
