// SPDX-License-Identifier: MIT
// What the Tracer says of itself, by the rows of its table.
#include <string_view>

#include "hil/devices/tracer_device.h"
#include "platform/can/tracer.h"

namespace pipewright::hil {
namespace {

using can::VehicleState;

constexpr double kPi = 3.14159265358979323846;

constexpr std::string_view kVersionText =
    "Pipewright's emulated TRACER, protocol V2                                       ";
static_assert(kVersionText.size() == 80);

/// Not inlined: gcc 12 would see a message without codes beside the codec's branch for codes, and
/// warn of a read that never happens.
template <typename Row, typename Msg>
[[gnu::noinline]] void Append(const Row& row, const Msg& msg, std::vector<can::Frame>& out,
                              int node = 0) {
  const Result<can::Frame> frame = can::Encode(row, msg, node);
  if (frame.ok()) {
    out.push_back(*frame);
  }
}

bool Due(Time& next, Time now, Duration period) {
  if (now < next) {
    return false;
  }
  next += period;
  return true;
}

}  // namespace

void TracerDevice::Publish(Time now, std::vector<can::Frame>& out) {
  if (Due(next_fast_, now, can::kBaseState.head.period)) {
    PublishFast(out);
  }
  if (Due(next_slow_, now, can::kBaseMotorSlow.head.period)) {
    PublishSlow(out);
  }
  if (version_asked_) {  // a frame a step
    PublishVersion(out);
  }
  if (Due(next_bms_, now, can::kBaseBattery.head.period)) {
    Append(can::kBaseBattery,
           can::BaseBattery{.charge_percent = config_.charge_percent,
                            .health_percent = 100,
                            .voltage_V = config_.battery_V,
                            .current_A = 0,
                            .temperature_degC = 25},
           out);
  }
}

void TracerDevice::PublishVersion(std::vector<can::Frame>& out) {
  can::Frame& frame = out.emplace_back();
  frame.id = can::kBaseVersion.head.id;
  frame.dlc = can::kBaseVersion.head.dlc;
  kVersionText.copy(reinterpret_cast<char*>(frame.data.data()), 8,
                    static_cast<std::size_t>(version_said_));
  version_said_ += 8;
  version_asked_ = version_said_ < static_cast<int>(kVersionText.size());
}

void TracerDevice::PublishFast(std::vector<can::Frame>& out) {
  const VehicleState state = emergency_stop_               ? VehicleState::kEmergencyStop
                             : exception_ || undervoltage_ ? VehicleState::kException
                                                           : VehicleState::kNormal;
  Append(can::kBaseState,
         can::BaseState{.vehicle_state = static_cast<std::uint32_t>(state),
                        .control_mode = config_.modes.Code(Mode()),
                        .battery_V = config_.battery_V,
                        .errors = ErrorBits(),
                        .count = count_state_++},
         out);
  Append(can::kBaseTwist, can::BaseTwist{.v_mps = v_mps_, .omega_radps = omega_radps_}, out);
  can::BaseLight lights = lights_;
  lights.count = count_light_++;
  Append(can::kBaseLightState, lights, out);
  const auto percent = [](double value, double full) {
    return full > 0 ? 100 * value / full : 0.0;
  };
  can::BaseRemote remote{.count = count_remote_++};
  if (remote_on_) {
    remote.swa = remote.swb = remote.swc = remote.swd = 3;
    remote.right_vertical = percent(remote_v_mps_, config_.v_max_mps);
    remote.left_horizontal = -percent(remote_omega_radps_, config_.omega_max_radps);
  }
  Append(can::kBaseRemote, remote, out);
  for (const int motor : {1, 2}) {
    const double rim_mps = motor == 1 ? LeftWheel_mps() : RightWheel_mps();
    const double rpm = rim_mps / config_.wheel_radius_m * 60 / (2 * kPi);
    Append(can::kBaseMotorFast, can::BaseMotorFast{.speed_rpm = rpm}, out, motor);
  }
  Append(can::kBaseOdometer, can::BaseOdometer{.left_m = left_m_, .right_m = right_m_}, out);
}

void TracerDevice::PublishSlow(std::vector<can::Frame>& out) const {
  constexpr std::uint32_t kCanLost = 1U << 4;
  constexpr std::uint32_t kEnabled = 1U << 6;
  for (const int motor : {1, 2}) {
    Append(can::kBaseMotorSlow,
           can::BaseMotorSlow{.driver_V = undervoltage_ ? 0 : config_.battery_V,
                              .driver_degC = 30,
                              .motor_degC = 30,
                              .driver_state = motor_lost_[motor - 1] ? kCanLost
                                              : Powered()            ? kEnabled
                                                                     : 0},
           out, motor);
  }
}

}  // namespace pipewright::hil
