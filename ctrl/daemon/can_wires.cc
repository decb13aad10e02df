// SPDX-License-Identifier: MIT
#include "ctrl/daemon/can_wires.h"

#include <cstdio>
#include <utility>

namespace pipewright {

CanWires::CanWires(std::string base, std::string arm)
    : base_name_(std::move(base)), arm_name_(std::move(arm)) {}

void CanWires::Note(const std::string& name, std::string_view why) {
  std::snprintf(error_, sizeof error_, "%s: %.*s", name.c_str(), static_cast<int>(why.size()),
                why.data());
}

Status CanWires::OpenOne(SocketCan& socket, const std::string& name) {
  const Status status = socket.is_open() ? Status::kOk : socket.Open(name);
  if (status != Status::kOk) {
    Note(name, socket.error_text());
  }
  return status;
}

Status CanWires::Open() {
  const Status base = OpenOne(base_, base_name_);
  return base == Status::kOk && !shared() ? OpenOne(arm_, arm_name_) : base;
}

bool CanWires::ListenTo(SocketCan& socket, const std::string& name, can::Frame& frame) {
  if (!socket.is_open()) {
    return false;
  }
  if (socket.Receive(frame)) {
    return true;
  }
  if (!socket.healthy()) {
    Note(name, socket.error_text());
    socket.Close();
  }
  return false;
}

bool CanWires::Listen(can::Frame& frame) {
  return ListenTo(base_, base_name_, frame) || ListenTo(arm_, arm_name_, frame);
}

Status CanWires::Start(RobotThreads& threads, Time epoch) {
  base_port_.SetEpoch(epoch);
  arm_port_.SetEpoch(epoch);
  return shared() ? threads.Start(base_port_, base_port_) : threads.Start(base_port_, arm_port_);
}

}  // namespace pipewright
