// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/control_rate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pipewright {
namespace {

constexpr int kLeastOwn_ms = 4;     ///< 250 Hz
constexpr int kLeastShared_ms = 8;  ///< 125 Hz
constexpr int kLongest_ms = 20;     ///< 50 Hz: feedback is stale after 50 ms

}  // namespace

int ArmCycle_ms(double rate_hz, bool shared) {
  const int period_ms = static_cast<int>(std::lround(1000 / rate_hz));
  const int least_ms = shared ? kLeastShared_ms : kLeastOwn_ms;
  return period_ms * ((std::max(period_ms, least_ms) + period_ms - 1) / period_ms);
}

std::string ControlRateError(double rate_hz, bool shared) {
  const double period_ms = 1000 / rate_hz;
  const double whole_ms = std::round(period_ms);
  if (!(whole_ms >= 1 && whole_ms <= kLongest_ms) || std::abs(period_ms - whole_ms) > 1e-6) {
    return fmt::format(
        "a period of {:g} ms; choose one of whole milliseconds, 1 to {}: "
        "50, 62.5, 100, 125, 200, 250, 500 or 1000 Hz",
        period_ms, kLongest_ms);
  }
  if (shared && whole_ms < kLeastShared_ms) {
    return fmt::format(
        "one bus at 500 kbit/s for base and arm carries at most {} Hz; choose two buses, or a "
        "lower rate",
        1000 / kLeastShared_ms);
  }
  return "";
}

}  // namespace pipewright
