// SPDX-License-Identifier: MIT
#include "tests/timing/replay/recorder.h"

#include <memory>

#include "tests/timing/replay/recording.h"

namespace pipewright::timing {
namespace {

using Port = can::LoopbackBus::Port;

/// A port that keeps what passes through it.
class TappedPort {
 public:
  TappedPort(Port& port, ReceivedFrames& in, TxBatch& out) : port_(port), in_(in), out_(out) {
    in_.clear();
    out_.clear();
  }

  Status Send(const can::Frame& frame) {
    all_kept_ = out_.push_back(frame) && all_kept_;
    return port_.Send(frame);
  }
  bool Receive(can::Frame& frame) {
    const bool any = port_.Receive(frame);
    all_kept_ = (!any || in_.push_back(frame)) && all_kept_;
    return any;
  }

  bool all_kept() const { return all_kept_; }

 private:
  Port& port_;
  ReceivedFrames& in_;
  TxBatch& out_;
  bool all_kept_ = true;
};

}  // namespace

const char* Record(bench::ControlLoop& loop, std::uint64_t seed, int skip, int cycles,
                   std::FILE* file) {
  RecordingHead head;
  head.seed = seed;
  head.loop = loop.config();
  head.scene = loop.cell().around().scene;
  TakeMap(loop.cell().map(), head);
  RecordingWriter writer(file, head);
  const auto cycle = std::make_unique<RecordedCycle>();
  bool all_kept = true;
  const auto recorded = [&](bench::RobotSide& robot, Port& base, Port& arm,
                            Time now) -> const ControlReport& {
    cycle->now = now;
    cycle->has_goal = robot.goal.HasNew();
    TappedPort base_tap(base, cycle->base_in, cycle->base_out);
    TappedPort arm_tap(arm, cycle->arm_in, cycle->arm_out);
    const ControlReport& report = bench::RunControlCycle(robot, base_tap, arm_tap, now);
    cycle->goal = robot.goal.Read();
    all_kept = all_kept && base_tap.all_kept() && arm_tap.all_kept();
    writer.Add(*cycle);
    return report;
  };
  if (!loop.Start(recorded)) {
    return "the devices did not come up";
  }
  for (int i = 0; i < skip + cycles; ++i) {
    cycle->counted = i >= skip;
    if (!loop.Cycle(recorded)) {
      return "a device is at fault";
    }
  }
  if (!all_kept) {
    return "a cycle had more frames than a recording holds";
  }
  return writer.Finish() ? nullptr : "the file was not written whole";
}

}  // namespace pipewright::timing
