// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "ctrl/daemon/wires.h"
#include "platform/linux/socket_can.h"

namespace pipewright {

/// One interface of the kernel for all, or the base's and the arm's.
class CanWires final : public Wires {
 public:
  CanWires(std::string base, std::string arm);

  Status Open() override;
  bool Listen(can::Frame& frame) override;
  bool is_open() const override { return base_.is_open() && (shared() || arm_.is_open()); }
  std::string_view error_text() const override { return error_; }
  Status Start(RobotThreads& threads, Time epoch) override;

 private:
  bool shared() const { return base_name_ == arm_name_; }
  Status OpenOne(SocketCan& socket, const std::string& name);
  bool ListenTo(SocketCan& socket, const std::string& name, can::Frame& frame);
  void Note(const std::string& name, std::string_view why);

  std::string base_name_;
  std::string arm_name_;
  SocketCan base_;
  SocketCan arm_;
  EpochPort<SocketCan> base_port_{base_};
  EpochPort<SocketCan> arm_port_{arm_};
  char error_[160] = "";
};

}  // namespace pipewright
