// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "ctrl/robot_program/control_task.h"
#include "platform/can/bus.h"
#include "platform/drivers/device_fault.h"

/// What a control cycle does with its buses: a bounded number of frames in, each frame out offered
/// once. What either leaves undone is counted, and the control task is told.
namespace pipewright {

/// What a cycle reads from a bus at most. The longest period, 20 ms, holds 425 of the shortest
/// frames at 1 Mbit/s: a node that babbles cannot outrun the reading. Where more wait, as after a
/// late cycle, the next reads on, and the robot brakes until the newest frame is reached.
inline constexpr int kFramesPerCycle = 512;

struct BusCounters {
  std::uint64_t backlogs = 0;       ///< times that frames were left unread
  std::uint64_t send_failures = 0;  ///< frames that a bus did not take
};

template <can::Bus B, typename Take>
void ReceiveFrames(B& bus, ControlTask& task, BusCounters& counters, const Take& take) {
  can::Frame frame;
  for (int i = 0; i < kFramesPerCycle; ++i) {
    if (!bus.Receive(frame)) {
      return;
    }
    take(frame);
  }
  ++counters.backlogs;
  task.OnBusTrouble();
}

/// Before the task's Step. One port may serve as both.
template <can::Bus Base, can::Bus Arm>
void ReceiveFrames(Base& base, Arm& arm, ControlTask& task, BusCounters& counters) {
  const bool shared = static_cast<const void*>(&base) == static_cast<const void*>(&arm);
  ReceiveFrames(base, task, counters, [&](const can::Frame& frame) {
    task.OnBaseFrame(frame);
    if (shared) {
      task.OnArmFrame(frame);
    }
  });
  if (!shared) {
    ReceiveFrames(arm, task, counters, [&](const can::Frame& frame) { task.OnArmFrame(frame); });
  }
}

/// After the task's Step. A frame that is not taken is not sent again: the next cycle has a newer
/// one, and the devices' own watchdogs stop them if that is not taken either.
template <can::Bus B>
void SendFrames(B& bus, const TxBatch& batch, ControlTask& task, BusCounters& counters) {
  for (const can::Frame& frame : batch) {
    if (bus.Send(frame) != Status::kOk) {
      ++counters.send_failures;
      task.OnBusTrouble();
    }
  }
}

}  // namespace pipewright
