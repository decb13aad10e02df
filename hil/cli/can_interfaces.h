// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "hil/cli/realtime_run.h"
#include "platform/linux/socket_can.h"

namespace pipewright::hil {

/// The kernel's CAN interfaces as a run needs them: on each a socket for the robot, one for the
/// emulated devices if they are wanted, one that listens for can.log.
class CanInterfaces {
 public:
  /// @param interfaces  one for all, or the base's and the arm's
  /// @returns an error that names the interface and the reason, or nothing
  std::string Open(const std::vector<std::string>& interfaces, bool with_devices);

  /// Valid as long as this.
  RealtimePorts Ports();

 private:
  struct Interface {
    explicit Interface(const std::string& its_name) : name(its_name) {}

    std::string name;
    SocketCan robot;
    SocketCan devices;
    SocketCan tap;
    PortOf<SocketCan> robot_port{robot};
    PortOf<SocketCan> devices_port{devices};
    PortOf<SocketCan> tap_port{tap};
  };

  std::deque<Interface> interfaces_;
  bool with_devices_ = false;
};

}  // namespace pipewright::hil
