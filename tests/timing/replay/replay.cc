// SPDX-License-Identifier: MIT
#include "tests/timing/replay/replay.h"

#include <algorithm>

#include "platform/can/candump.h"
#include "tests/timing/replay/frame_difference.h"
#include "tests/timing/replay/stack_mark.h"

namespace pipewright::timing {
namespace {

void Compare(BusName bus, const TxBatch& recorded, const TxBatch& sent, ReplayResult& result) {
  const int both = std::min(recorded.size(), sent.size());
  const int missing = std::max(recorded.size(), sent.size()) - both;
  result.frames += recorded.size();
  result.different += missing;
  result.incomparable += missing;
  for (int i = 0; i < both; ++i) {
    if (recorded[i] == sent[i]) {
      continue;
    }
    ++result.different;
    if (const auto lsb = LsbDifference(bus, recorded[i], sent[i])) {
      result.largest_lsb = std::max(result.largest_lsb, *lsb);
    } else {
      ++result.incomparable;
    }
  }
}

void Print(const TxBatch& batch, const char* interface, Time now, std::FILE* out) {
  for (can::Frame frame : batch) {
    frame.stamp = now;
    char line[can::kCandumpLineBytes];
    const Result<int> length = can::FormatCandump(frame, interface, line);
    if (length.ok()) {
      static_cast<void>(std::fwrite(line, 1, static_cast<std::size_t>(*length), out));
    }
  }
}

}  // namespace

/// A function of its own: the head and the grid that it makes need not outlive it.
bool Replay::Start(RecordingReader& recording) {
  RecordingHead head;
  if (!recording.ReadHead(head)) {
    return false;
  }
  robot_.emplace(bench::TaskConfig(head.loop), head.map);
  Surrounding& around = robot_->surrounding.Back();
  around.scene = head.scene;
  around.field.Update(MakeMap(head));
  robot_->surrounding.Publish();
  return robot_->task.status() == Status::kOk;
}

// Not inlined: what is painted begins below its caller.
[[gnu::noinline]] void Replay::RunCycle() {
  if (cycle_.counted) {
    pipewright_replayed_cycle(*robot_, base_, arm_, cycle_.now);
    pipewright_cycle_done();
  } else {
    bench::RunControlCycle(*robot_, base_, arm_, cycle_.now);
  }
}

bool Replay::Run(RecordingReader& recording, std::FILE* sent, ReplayResult& result) {
  if (!Start(recording)) {
    return false;
  }
  result.field_bytes = 3 * robot_->surrounding.Read().field.MemoryBytes();
  while (recording.Next(cycle_)) {
    if (cycle_.has_goal) {
      robot_->goal.Write(cycle_.goal);
    }
    base_.Load(cycle_.base_in);
    arm_.Load(cycle_.arm_in);
    PaintStack();
    RunCycle();
    result.stack_bytes = std::max(result.stack_bytes, StackUsed());
    const int different = result.different;
    Compare(BusName::kBase, cycle_.base_out, base_.sent(), result);
    Compare(BusName::kArm, cycle_.arm_out, arm_.sent(), result);
    if (result.first_different < 0 && result.different > different) {
      result.first_different = result.cycles;
    }
    if (sent != nullptr) {
      Print(base_.sent(), "can0", cycle_.now, sent);
      Print(arm_.sent(), "can1", cycle_.now, sent);
    }
    ++result.cycles;
    result.counted += cycle_.counted ? 1 : 0;
    result.many_rows += cycle_.counted && robot_->task.report().stats.rows >= kManyRows ? 1 : 0;
  }
  return recording.problem() == nullptr;
}

}  // namespace pipewright::timing
