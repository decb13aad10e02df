// SPDX-License-Identifier: MIT
#pragma once

#include "tests/bench/robot_side.h"
#include "tests/timing/replay/recording.h"

namespace pipewright::timing {

/// A bus that gives what was received then, and keeps what is sent.
class ReplayPort {
 public:
  void Load(const ReceivedFrames& in) {
    in_ = &in;
    next_ = 0;
    sent_.clear();
  }

  Status Send(const can::Frame& frame) {
    return sent_.push_back(frame) ? Status::kOk : Status::kFull;
  }
  bool Receive(can::Frame& frame) {
    if (next_ == in_->size()) {
      return false;
    }
    frame = (*in_)[next_++];
    return true;
  }

  const TxBatch& sent() const { return sent_; }

 private:
  const ReceivedFrames* in_ = nullptr;
  int next_ = 0;
  TxBatch sent_;
};

}  // namespace pipewright::timing

/// RunControlCycle on replayed buses, under a name that instruction counters find on any machine:
/// what lies between the first instruction of pipewright_replayed_cycle and that of
/// pipewright_cycle_done is one cycle. Both are in a file of their own, so that no call is inlined.
extern "C" {
void pipewright_replayed_cycle(pipewright::bench::RobotSide& robot,
                               pipewright::timing::ReplayPort& base,
                               pipewright::timing::ReplayPort& arm, pipewright::Time now);
void pipewright_cycle_done();
}
