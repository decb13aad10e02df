// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "ctrl/robot_program/threads.h"
#include "platform/can/bus.h"
#include "platform/core/status.h"

namespace pipewright {

/// A bus whose stamps count from the start of a run. Clock and stamps are those of Now().
template <can::Bus B>
class EpochPort {
 public:
  explicit EpochPort(B& bus) : bus_(bus) {}

  void SetEpoch(Time epoch) { epoch_ = epoch; }
  Status Send(const can::Frame& frame) { return bus_.Send(frame); }
  bool Receive(can::Frame& frame) {
    if (!bus_.Receive(frame)) {
      return false;
    }
    frame.stamp = Time{frame.stamp - epoch_};
    return true;
  }

 private:
  B& bus_;
  Time epoch_{};
};

/// The service's way to the buses. Between runs it listens itself; during a run they are the
/// control thread's alone, which reaches them without a virtual call.
class Wires {
 public:
  virtual ~Wires() = default;

  /// Opens what is not open. kUnavailable: error_text() names the interface and the reason.
  virtual Status Open() = 0;
  /// Frames of either bus, never waiting; stamps are Now()'s. A bus that has gone away is closed.
  virtual bool Listen(can::Frame& frame) = 0;
  virtual bool is_open() const = 0;
  virtual std::string_view error_text() const = 0;

  /// Hands the buses to the threads; they have them until the threads have returned.
  virtual Status Start(RobotThreads& threads, Time epoch) = 0;
};

}  // namespace pipewright
