// SPDX-License-Identifier: MIT
#pragma once

#include "platform/can/bus.h"

namespace pipewright::hil {

/// Any can::Bus behind one virtual call, so that devices do not care whether their wire is a
/// LoopbackBus port or an interface of the kernel.
class Port {
 public:
  virtual ~Port() = default;
  virtual Status Send(const can::Frame& frame) = 0;
  virtual bool Receive(can::Frame& frame) = 0;
};

/// `bus` must outlive the port.
template <can::Bus B>
class PortOf final : public Port {
 public:
  explicit PortOf(B& bus) : bus_(bus) {}
  Status Send(const can::Frame& frame) override { return bus_.Send(frame); }
  bool Receive(can::Frame& frame) override { return bus_.Receive(frame); }

 private:
  B& bus_;
};

}  // namespace pipewright::hil
