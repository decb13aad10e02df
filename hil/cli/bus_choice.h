// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "ctrl/robot_program/control_rate.h"

namespace pipewright::hil {

/// What --bus asks for.
///
///   loopback          two buses in virtual time: the base's, 500 kbit/s, and the arm's, 1 Mbit/s
///   loopback-shared   one bus in virtual time, 500 kbit/s
///   IFACE             one interface of the kernel for all
///   IFACE,IFACE       the base's and the arm's
struct BusChoice {
  bool shared = false;
  std::vector<std::string> interfaces;  ///< empty: virtual time

  bool is_virtual() const { return interfaces.empty(); }
};

/// @param error  set, in words, when `bus` is none of these
BusChoice ParseBus(const std::string& bus, std::string* error);

/// Why --rate cannot be `rate_hz`, in words; empty if it can.
std::string RateError(double rate_hz, bool shared);

}  // namespace pipewright::hil
