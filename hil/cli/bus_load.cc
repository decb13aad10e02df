// SPDX-License-Identifier: MIT
#include "hil/cli/bus_load.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "platform/can/cia402.h"
#include "platform/can/tracer.h"

namespace pipewright::hil {
namespace {

constexpr int kHeartbeats = can::kArmNodes + 1;  ///< the host has one, too

double FramesPerSecond(const can::FrameHead& head) {
  return head.period > Duration::zero() ? 1 / ToSeconds(head.period) : 0;
}

template <typename Row>
double BitsPerSecond(const Row& row) {
  return std::max(row.head.max_node, 1) * FramesPerSecond(row.head) * WorstFrameBits(row.head.dlc);
}

}  // namespace

int WorstFrameBits(int payload_bytes) {
  return 47 + 8 * payload_bytes + (34 + 8 * payload_bytes - 1) / 4;
}

double BaseLoad(int bitrate) {
  const double bits =
      std::apply([](const auto&... row) { return (BitsPerSecond(row) + ...); }, can::kTracerTable);
  return bits / bitrate;
}

double ArmLoad(double cycle_hz, int bitrate) {
  const int cycle_bits =
      WorstFrameBits(0) + can::kArmNodes * (WorstFrameBits(can::kJointCommand.head.dlc) +
                                            WorstFrameBits(can::kJointFeedback.head.dlc));
  const double heartbeat_bits = kHeartbeats * FramesPerSecond(can::kHeartbeat.head) *
                                WorstFrameBits(can::kHeartbeat.head.dlc);
  return (cycle_hz * cycle_bits + BitsPerSecond(can::kJointStatus) + heartbeat_bits) / bitrate;
}

std::string LoadError(double cycle_hz, bool shared) {
  const double load = shared
                          ? BaseLoad(can::kTracerBitrate) + ArmLoad(cycle_hz, can::kTracerBitrate)
                          : ArmLoad(cycle_hz, can::kArmBitrate);
  if (load <= kBusLoadLimit) {
    return "";
  }
  return fmt::format(
      "--rate {:g}: {} at {} kbit/s would be filled to {:.0f} % at worst, more than {:.0f} %; {}",
      cycle_hz, shared ? "one bus for base and arm" : "the arm's bus",
      (shared ? can::kTracerBitrate : can::kArmBitrate) / 1000, 100 * load, 100 * kBusLoadLimit,
      shared ? "choose a lower rate, or give the arm a bus of its own with --arm-bus"
             : "choose a lower rate");
}

}  // namespace pipewright::hil
