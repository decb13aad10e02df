// SPDX-License-Identifier: MIT
#include "tests/timing/replay/replay.h"

#include <algorithm>
#include <memory>
#include <span>

#include "platform/can/candump.h"
#include "tests/timing/replay/frame_difference.h"
#include "tests/timing/replay/replayed_cycle.h"
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

/// Apart from what follows: the grid and the head need not outlive it.
std::unique_ptr<bench::RobotSide> Start(RecordingReader& recording) {
  RecordingHead head;
  if (!recording.ReadHead(head)) {
    return nullptr;
  }
  auto robot = std::make_unique<bench::RobotSide>(bench::TaskConfig(head.loop), head.map);
  Surrounding& around = robot->surrounding.Back();
  around.scene = head.scene;
  around.field.Update(MakeMap(head));
  robot->surrounding.Publish();
  return robot;
}

struct Buses {
  ReplayPort base;
  ReplayPort arm;
};

[[gnu::noinline]] void RunCycle(const RecordedCycle& cycle, bench::RobotSide& robot, Buses& buses) {
  if (cycle.counted) {
    pipewright_replayed_cycle(robot, buses.base, buses.arm, cycle.now);
    pipewright_cycle_done();
  } else {
    bench::RunControlCycle(robot, buses.base, buses.arm, cycle.now);
  }
}

}  // namespace

bool Replay(RecordingReader& recording, std::FILE* sent, ReplayResult& result) {
  const std::unique_ptr<bench::RobotSide> robot = Start(recording);
  if (robot == nullptr || robot->task.status() != Status::kOk) {
    return false;
  }
  result.field_bytes = 3 * robot->surrounding.Read().field.MemoryBytes();
  const auto cycle = std::make_unique<RecordedCycle>();
  const auto buses = std::make_unique<Buses>();
  while (recording.Next(*cycle)) {
    if (cycle->has_goal) {
      robot->goal.Write(cycle->goal);
    }
    buses->base.Load(cycle->base_in);
    buses->arm.Load(cycle->arm_in);
    PaintStack();
    RunCycle(*cycle, *robot, *buses);
    result.stack_bytes = std::max(result.stack_bytes, StackUsed());
    const int different = result.different;
    Compare(BusName::kBase, cycle->base_out, buses->base.sent(), result);
    Compare(BusName::kArm, cycle->arm_out, buses->arm.sent(), result);
    if (result.first_different < 0 && result.different > different) {
      result.first_different = result.cycles;
    }
    if (sent != nullptr) {
      Print(buses->base.sent(), "can0", cycle->now, sent);
      Print(buses->arm.sent(), "can1", cycle->now, sent);
    }
    ++result.cycles;
    result.counted += cycle->counted ? 1 : 0;
  }
  return recording.problem() == nullptr;
}

}  // namespace pipewright::timing
