// SPDX-License-Identifier: MIT
#include "hil/devices/tracer_device.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "platform/can/tracer.h"

namespace pipewright::hil {
namespace {

using can::ControlMode;

constexpr double kUndervoltage_V = 22.0;         // the drives lose their power
constexpr double kUndervoltageWarning_V = 22.5;  // and get it back

/// 0x111 as the base reads it: what its limits forbid is clamped, not refused.
constexpr auto AnyTwistCommand() {
  auto row = can::kBaseTwistCommand;
  for (auto& signal : row.signals) {
    signal.min = -0x1p15 * signal.scale;
    signal.max = (0x1p15 - 1) * signal.scale;
  }
  return row;
}
constexpr auto kAnyTwistCommand = AnyTwistCommand();
static_assert(can::WellFormed(kAnyTwistCommand));

double Ramp(double from, double to, double step) {
  return from + std::clamp(to - from, -step, step);
}

}  // namespace

bool TracerConfig::Valid() const {
  return track_m > 0 && wheel_radius_m > 0 && v_max_mps >= 0 && omega_max_radps >= 0 &&
         accel_mps2 > 0 && alpha_radps2 > 0 && brake_mps2 > 0 && brake_radps2 > 0 &&
         stop_mps2 > 0 && stop_radps2 > 0 && command_timeout > Duration::zero() &&
         boot_time >= Duration::zero() && std::isfinite(battery_V) && charge_percent >= 0 &&
         charge_percent <= 100 && slip.Valid();
}

TracerDevice::TracerDevice(const TracerConfig& config) : config_(config), slip_(config.slip) {
  assert(config.Valid());
  SetBattery(config.battery_V, config.charge_percent);
}

void TracerDevice::OnFrame(const can::Frame& frame, Time now) {
  if (!booted_ || now < *booted_) {
    return;
  }
  switch (frame.id) {
    case can::kBaseTwistCommand.head.id:
      return OnMotionCommand(frame, now);
    case can::kBaseLightCommand.head.id:
      return OnLightCommand(frame);
    case can::kBaseModeRequest.head.id:
      return OnModeCommand(frame);
    case can::kBaseErrorReset.head.id:
      return OnReset(frame);
    case kVersionRequestId:
    case can::kBaseVersion.head.id:
      return OnVersionRequest(frame);
    default:
      return;
  }
}

void TracerDevice::OnMotionCommand(const can::Frame& frame, Time now) {
  const Result<can::BaseTwistCommand> command = can::Decode(kAnyTwistCommand, frame);
  if (!command.ok()) {
    ++rejected_;
    return;
  }
  if (!can_mode_ || remote_on_) {
    return;
  }
  last_command_ = now;
  timed_out_ = false;
  target_v_mps_ = std::clamp(command->v_mps, -config_.v_max_mps, config_.v_max_mps);
  target_omega_radps_ =
      std::clamp(command->omega_radps, -config_.omega_max_radps, config_.omega_max_radps);
}

void TracerDevice::OnLightCommand(const can::Frame& frame) {
  const Result<can::BaseLight> lights = can::Decode(can::kBaseLightCommand, frame);
  if (!lights.ok()) {
    ++rejected_;
    return;
  }
  lights_ = *lights;
  lights_.rear_mode = 0;  // a Tracer has no rear light
  lights_.rear_percent = 0;
}

void TracerDevice::OnModeCommand(const can::Frame& frame) {
  const Result<can::BaseModeRequest> request = can::Decode(can::kBaseModeRequest, frame);
  if (!request.ok()) {
    ++rejected_;
    return;
  }
  if (remote_on_) {
    return;
  }
  const bool wanted = request->mode == 1;
  if (wanted != can_mode_) {
    last_command_.reset();
    target_v_mps_ = 0;
    target_omega_radps_ = 0;
  }
  can_mode_ = wanted;
}

void TracerDevice::OnReset(const can::Frame& frame) {
  const Result<can::BaseErrorReset> reset = can::Decode(can::kBaseErrorReset, frame);
  if (!reset.ok()) {
    ++rejected_;
    return;
  }
  exception_ = motor_lost_[0] || motor_lost_[1];
}

void TracerDevice::OnVersionRequest(const can::Frame& frame) {
  if (frame.extended || frame.error) {
    return;
  }
  if (frame.remote || frame.dlc < 1 || frame.data[0] != 1) {
    ++rejected_;
    return;
  }
  version_asked_ = true;
  version_said_ = 0;
}

void TracerDevice::SetRemote(bool on, double v_mps, double omega_radps) {
  if (remote_on_ != on) {  // the transmitter takes the base out of CAN mode, and does not give back
    can_mode_ = false;
    last_command_.reset();
    target_v_mps_ = 0;
    target_omega_radps_ = 0;
  }
  remote_on_ = on;
  remote_v_mps_ = std::clamp(v_mps, -config_.v_max_mps, config_.v_max_mps);
  remote_omega_radps_ = std::clamp(omega_radps, -config_.omega_max_radps, config_.omega_max_radps);
}

void TracerDevice::SetBattery(double volts, double charge_percent) {
  config_.battery_V = std::clamp(volts, 0.0, 100.0);
  config_.charge_percent = std::clamp(charge_percent, 0.0, 100.0);
  if (volts < kUndervoltage_V) {
    undervoltage_ = true;
  } else if (volts >= kUndervoltageWarning_V) {
    undervoltage_ = false;
  }
}

void TracerDevice::LoseMotorDriver(int motor, bool lost) {
  assert(motor == 1 || motor == 2);
  motor_lost_[motor - 1] = lost;
  exception_ = exception_ || lost;
}

BaseMotion TracerDevice::motion() const {
  return slip_.Motion({v_mps_, omega_radps_}, config_.track_m);
}

bool TracerDevice::Powered() const { return !emergency_stop_ && !exception_ && !undervoltage_; }

ControlMode TracerDevice::Mode() const {
  return remote_on_ ? ControlMode::kRemote : can_mode_ ? ControlMode::kCan : ControlMode::kStandby;
}

std::uint32_t TracerDevice::ErrorBits() const {
  std::uint32_t bits = 0;
  bits |= undervoltage_ ? can::base_error::kUndervoltage : 0;
  bits |= config_.battery_V < kUndervoltageWarning_V ? can::base_error::kUndervoltageWarning : 0;
  bits |= motor_lost_[0] ? can::base_error::kMotor1Lost : 0;
  bits |= motor_lost_[1] ? can::base_error::kMotor2Lost : 0;
  bits |= emergency_stop_ ? config_.estop_error : 0;
  return bits;
}

void TracerDevice::Drive(double dt_s, Time now) {
  double v = 0;
  double omega = 0;
  double accel = config_.stop_mps2;
  double alpha = config_.stop_radps2;
  if (Powered() && remote_on_) {
    v = remote_v_mps_;
    omega = remote_omega_radps_;
    accel = config_.accel_mps2;
    alpha = config_.alpha_radps2;
  } else if (Powered()) {
    if (last_command_ && now - *last_command_ > config_.command_timeout && !timed_out_) {
      timed_out_ = true;
      ++watchdog_trips_;
    }
    const bool commanded = can_mode_ && last_command_ && !timed_out_;
    v = commanded ? target_v_mps_ : 0;
    omega = commanded ? target_omega_radps_ : 0;
    accel = commanded ? config_.accel_mps2 : config_.brake_mps2;
    alpha = commanded ? config_.alpha_radps2 : config_.brake_radps2;
  }
  v_mps_ = Ramp(v_mps_, v, accel * dt_s);
  omega_radps_ = Ramp(omega_radps_, omega, alpha * dt_s);
  const double left_m = LeftWheel_mps() * dt_s;
  const double right_m = RightWheel_mps() * dt_s;
  left_m_ += left_m;
  right_m_ += right_m;
  slip_.Roll(left_m, right_m);
}

double TracerDevice::LeftWheel_mps() const { return v_mps_ - omega_radps_ * config_.track_m / 2; }

double TracerDevice::RightWheel_mps() const { return v_mps_ + omega_radps_ * config_.track_m / 2; }

void TracerDevice::Step(Time now, std::vector<can::Frame>& out) {
  if (!booted_) {
    booted_ = now + config_.boot_time;
    next_fast_ = next_slow_ = next_bms_ = *booted_;
    last_ = now;
    return;
  }
  Drive(ToSeconds(now - last_), now);
  last_ = now;
  if (now >= *booted_) {
    Publish(now, out);
  }
}

}  // namespace pipewright::hil
