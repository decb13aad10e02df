// SPDX-License-Identifier: MIT
#include "hil/cli/bus_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pipewright::hil {
namespace {

constexpr int kLeastOwn_ms = 4;     ///< 250 Hz
constexpr int kLeastShared_ms = 8;  ///< 125 Hz
constexpr int kLongest_ms = 20;     ///< 50 Hz: feedback is stale after 50 ms

std::vector<std::string> Split(const std::string& text) {
  std::vector<std::string> parts;
  std::size_t from = 0;
  while (true) {
    const std::size_t comma = text.find(',', from);
    parts.push_back(text.substr(from, comma - from));
    if (comma == std::string::npos) {
      return parts;
    }
    from = comma + 1;
  }
}

}  // namespace

BusChoice ParseBus(const std::string& bus, std::string* error) {
  BusChoice choice;
  if (bus == "loopback" || bus == "loopback-shared") {
    choice.shared = bus != "loopback";
    return choice;
  }
  choice.interfaces = Split(bus);
  bool sound = choice.interfaces.size() <= 2;
  for (const std::string& name : choice.interfaces) {
    sound = sound && !name.empty() && name != "loopback" && name != "loopback-shared";
  }
  if (!sound) {
    *error = fmt::format(
        "--bus {}: neither loopback, loopback-shared, an interface (can0) nor two (can0,can1)",
        bus);
  }
  if (choice.interfaces.size() == 2 && choice.interfaces[0] == choice.interfaces[1]) {
    choice.interfaces.pop_back();
  }
  choice.shared = choice.interfaces.size() == 1;
  return choice;
}

int ArmCycle_ms(double rate_hz, bool shared) {
  const int period_ms = static_cast<int>(std::lround(1000 / rate_hz));
  const int least_ms = shared ? kLeastShared_ms : kLeastOwn_ms;
  return period_ms * ((std::max(period_ms, least_ms) + period_ms - 1) / period_ms);
}

std::string RateError(double rate_hz, bool shared) {
  const double period_ms = 1000 / rate_hz;
  const double whole_ms = std::round(period_ms);
  if (!(whole_ms >= 1 && whole_ms <= kLongest_ms) || std::abs(period_ms - whole_ms) > 1e-6) {
    return fmt::format(
        "--rate {:g}: a period of {:g} ms; choose one of whole milliseconds, 1 to {}: "
        "50, 62.5, 100, 125, 200, 250, 500 or 1000 Hz",
        rate_hz, period_ms, kLongest_ms);
  }
  if (shared && whole_ms < kLeastShared_ms) {
    return fmt::format(
        "--rate {:g}: one bus at 500 kbit/s for base and arm carries at most {} Hz; choose two "
        "buses, or a lower rate",
        rate_hz, 1000 / kLeastShared_ms);
  }
  return "";
}

}  // namespace pipewright::hil
