// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <thread>
#include <vector>

#include "ctrl/daemon/frame_source.h"
#include "ctrl/daemon/wires.h"
#include "hil/emulator/emulator.h"
#include "platform/core/latest.h"
#include "platform/linux/clock.h"
#include "platform/robot/uf7.h"
#include "tests/support/threaded_bus.h"

namespace pipewright::test {

/// The emulated robot in real time, on a thread of its own, with its camera.
class RobotBench final : public FrameSource {
 public:
  RobotBench(const hil::Scenario& scenario, ThreadedBus& base, ThreadedBus& arm)
      : emulator_(scenario, HomeJoints(TracerUf7()), 1, {base.Attach(), arm.Attach()}) {}
  ~RobotBench() override { Stop(); }

  void Start() {
    thread_ = std::thread([this] { Run(); });
  }
  void Stop() {
    quit_ = true;
    if (thread_.joinable()) {
      thread_.join();
    }
  }
  /// Latest that a step of the devices has been: a busy machine.
  Duration late_max() const { return late_max_; }
  /// After Stop().
  const hil::Emulator& emulator() const { return emulator_; }
  hil::DeviceSet& devices() { return emulator_.devices(); }

  Status Poll(Time, DepthFrame& frame) override {
    if (!frames_.HasNew()) {
      return Status::kTimeout;
    }
    frame = frames_.Read();
    return Status::kOk;
  }
  std::string_view error_text() const override { return ""; }

 private:
  void Run() {
    const Time epoch = Now();
    Time now{};
    while (!quit_) {
      const Time until{Now() - epoch};
      late_max_ = std::max(late_max_.load(), until - now);
      while (now + hil::Emulator::kTick <= until && !quit_) {
        now += hil::Emulator::kTick;
        emulator_.Step(now);
        if (emulator_.FrameDue(now)) {
          DepthFrame& frame = frames_.Back();
          emulator_.Render(frame);
          frame.stamp = epoch + frame.stamp.time_since_epoch();
          frames_.Publish();
        }
      }
      SleepUntil(epoch + (now + hil::Emulator::kTick).time_since_epoch());
    }
  }

  hil::Emulator emulator_;
  Latest<DepthFrame> frames_;
  std::atomic<bool> quit_ = false;
  std::atomic<Duration> late_max_{};
  std::thread thread_;
};

/// Wires over buses within the process. One can be unplugged, and the control thread can be hung.
class ThreadedWires final : public Wires {
 public:
  ThreadedWires(ThreadedBus& base, ThreadedBus& arm)
      : base_{base.Attach(), *this}, arm_{arm.Attach(), *this} {}

  Status Open() override { return plugged ? Status::kOk : Status::kUnavailable; }
  bool Listen(can::Frame& frame) override {
    return plugged && (base_.Receive(frame) || arm_.Receive(frame));
  }
  bool is_open() const override { return plugged; }
  std::string_view error_text() const override { return "test0: \"unplugged\""; }
  Status Start(RobotThreads& threads, Time epoch) override {
    base_port_.SetEpoch(epoch);
    arm_port_.SetEpoch(epoch);
    return threads.Start(base_port_, arm_port_);
  }

  std::atomic<bool> plugged = true;
  std::atomic<bool> hung = false;  ///< whoever receives waits until it is not
  std::atomic<int> sent = 0;       ///< frames, by the robot program

 private:
  struct Wire {
    ThreadedBus::Port* port;
    ThreadedWires& wires;

    Status Send(const can::Frame& frame) {
      ++wires.sent;
      return port->Send(frame);
    }
    bool Receive(can::Frame& frame) {
      while (wires.hung) {
        SleepUntil(Now() + std::chrono::milliseconds(1));
      }
      return port->Receive(frame);
    }
  };

  Wire base_;
  Wire arm_;
  EpochPort<Wire> base_port_{base_};
  EpochPort<Wire> arm_port_{arm_};
};

}  // namespace pipewright::test
