// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "hil/devices/port.h"
#include "platform/can/loopback_bus.h"
#include "platform/linux/clock.h"

namespace pipewright {

/// A bus between threads: what a port sends, every other port has at once, stamped with Now(). No
/// heap once it runs.
class ThreadedBus {
 public:
  class Port final : public hil::Port {
   public:
    explicit Port(ThreadedBus& bus) : bus_(bus) {}
    Status Send(const can::Frame& frame) override {
      const std::lock_guard<std::mutex> lock(bus_.mutex_);
      can::Frame carried = frame;
      carried.stamp = Now();
      for (const std::unique_ptr<Port>& port : bus_.ports_) {
        if (port.get() != this) {
          port->lost_ += port->waiting_.Push(carried) ? 0 : 1;
        }
      }
      return Status::kOk;
    }
    bool Receive(can::Frame& frame) override {
      const std::lock_guard<std::mutex> lock(bus_.mutex_);
      if (waiting_.empty()) {
        return false;
      }
      frame = waiting_.Front();
      waiting_.Pop();
      return true;
    }
    /// Frames that came while 4096 waited. After the threads have ended.
    int lost() const { return lost_; }

   private:
    ThreadedBus& bus_;
    can::FrameQueue<4096> waiting_;
    int lost_ = 0;
  };

  /// Before the threads start.
  Port* Attach() { return ports_.emplace_back(std::make_unique<Port>(*this)).get(); }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Port>> ports_;
};

}  // namespace pipewright
