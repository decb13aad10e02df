// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace pipewright {

/// Milliseconds from one SYNC to the next: the control period where the bus carries that, else the
/// least multiple of it that the bus carries. A cycle's frames of the arm, 8 out and 7 to 14 in,
/// take some 1.7 ms at 1 Mbit/s (measured: 42 % at 250 Hz). On a shared bus at 500 kbit/s, base and
/// arm fill 53 % at 125 Hz.
/// @pre ControlRateError() is empty
int ArmCycle_ms(double rate_hz, bool shared);

/// Why control cannot run at `rate_hz`, in words; empty if it can. Periods are whole milliseconds,
/// 1 to 20. On a shared bus they are at least 8 ms.
std::string ControlRateError(double rate_hz, bool shared);

}  // namespace pipewright
