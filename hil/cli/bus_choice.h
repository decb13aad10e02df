// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

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

/// Milliseconds from one SYNC to the next: the control period where the bus carries that, else the
/// least multiple of it that the bus carries. A cycle's frames of the arm, 8 out and 7 to 14 in,
/// take some 1.7 ms at 1 Mbit/s (measured: 42 % at 250 Hz). On a shared bus at 500 kbit/s, base and
/// arm fill 53 % at 125 Hz.
/// @pre RateError() is empty
int ArmCycle_ms(double rate_hz, bool shared);

/// Why control cannot run at `rate_hz`, in words; empty if it can. Periods are whole milliseconds,
/// 1 to 20. On a shared bus they are at least 8 ms.
std::string RateError(double rate_hz, bool shared);

}  // namespace pipewright::hil
