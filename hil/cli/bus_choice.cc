// SPDX-License-Identifier: MIT
#include "hil/cli/bus_choice.h"

#include <fmt/format.h>

namespace pipewright::hil {
namespace {

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

std::string RateError(double rate_hz, bool shared) {
  const std::string error = ControlRateError(rate_hz, shared);
  return error.empty() ? "" : fmt::format("--rate {:g}: {}", rate_hz, error);
}

}  // namespace pipewright::hil
