// SPDX-License-Identifier: MIT
#include "hil/devices/csv_drive.h"

#include <algorithm>
#include <cmath>

namespace pipewright::hil {
namespace {

/// The largest speed from which steps of dt, each slower by at most a dt, come to rest within d.
/// In units u = a dt: v = n + f goes (n + f) + ... + f = (n + 1) f + n (n + 1) / 2 steps of u dt.
double StoppingSpeed(double d, double a, double dt_s) {
  const double steps = std::max(d, 0.0) / (a * dt_s * dt_s);
  const double n = std::floor((std::sqrt(1 + 8 * steps) - 1) / 2);
  const double f = (steps - n * (n + 1) / 2) / (n + 1);
  return (n + f) * a * dt_s;
}

double Towards(double from, double to, double step) {
  return from + std::clamp(to - from, -step, step);
}

/// CiA 402-2, table 30: the statusword's bits 0-3, 5 and 6.
std::uint32_t StateBits(DriveState state) {
  switch (state) {
    case DriveState::kNotReady:
    case DriveState::kUnknown:
      return 0x00;
    case DriveState::kSwitchOnDisabled:
      return 0x40;
    case DriveState::kReadyToSwitchOn:
      return 0x21;
    case DriveState::kSwitchedOn:
      return 0x23;
    case DriveState::kOperationEnabled:
      return 0x27;
    case DriveState::kQuickStopActive:
      return 0x07;
    case DriveState::kFaultReaction:
      return 0x0F;
    case DriveState::kFault:
      return 0x08;
  }
  return 0x00;
}

/// The commands of CiA 402-2, table 28, as a controlword's bits 0-3 and 7 spell them.
struct Order {
  bool shutdown, switch_on, enable, disable_voltage, quick_stop;

  explicit Order(std::uint16_t word)
      : shutdown((word & 0x87) == 0x06),
        switch_on((word & 0x8F) == 0x07),
        enable((word & 0x8F) == 0x0F),
        disable_voltage((word & 0x82) == 0x00),
        quick_stop((word & 0x86) == 0x02) {}
};

/// The transitions of CiA 402-2, figure 2 that a controlword causes; `stays` is 605Ah's option that
/// lets a quick stop be left for operation enabled.
DriveState Next(DriveState from, const Order& order, bool reset_edge, bool stays) {
  switch (from) {
    case DriveState::kFault:
      return reset_edge ? DriveState::kSwitchOnDisabled : from;
    case DriveState::kSwitchOnDisabled:
      return order.shutdown ? DriveState::kReadyToSwitchOn : from;
    case DriveState::kReadyToSwitchOn:
    case DriveState::kSwitchedOn:
      if (order.disable_voltage || order.quick_stop) {
        return DriveState::kSwitchOnDisabled;
      }
      break;
    case DriveState::kOperationEnabled:
      if (order.disable_voltage) {
        return DriveState::kSwitchOnDisabled;
      }
      if (order.quick_stop) {
        return DriveState::kQuickStopActive;
      }
      break;
    case DriveState::kQuickStopActive:
      if (order.disable_voltage) {
        return DriveState::kSwitchOnDisabled;
      }
      return order.enable && stays ? DriveState::kOperationEnabled : from;
    case DriveState::kNotReady:
    case DriveState::kFaultReaction:
    case DriveState::kUnknown:
      return from;
  }
  if (order.shutdown) {
    return DriveState::kReadyToSwitchOn;
  }
  if (order.switch_on) {
    return DriveState::kSwitchedOn;
  }
  return order.enable ? DriveState::kOperationEnabled : from;
}

}  // namespace

void CsvDrive::PowerUp() {
  if (state_ == DriveState::kNotReady) {
    state_ = DriveState::kSwitchOnDisabled;
  }
}

void CsvDrive::Restart() {
  state_ = DriveState::kNotReady;
  quick_stop_option_ = QuickStopOption::kRampThenDisable;
  controlword_ = 0;
  internal_limit_ = false;
  waits_ = false;
}

void CsvDrive::Command(std::uint16_t controlword) {
  const bool reset_edge = (controlword & 0x80) != 0 && (controlword_ & 0x80) == 0;
  controlword_ = controlword;
  if (state_ == DriveState::kFault && fault_held_) {
    reset_asked_ = reset_asked_ || reset_edge;
    return;
  }
  const DriveState next = Next(state_, Order(controlword), reset_edge,
                               quick_stop_option_ == QuickStopOption::kRampThenStay);
  waits_ = next == DriveState::kOperationEnabled && state_ != next && !permitted_;
  if (!waits_) {
    state_ = next;
  } else if (state_ == DriveState::kReadyToSwitchOn) {
    state_ = DriveState::kSwitchedOn;
  }
}

void CsvDrive::PermitOperation(bool permitted) {
  permitted_ = permitted;
  const bool ready = state_ == DriveState::kSwitchedOn || state_ == DriveState::kQuickStopActive;
  if (permitted && waits_ && ready) {
    state_ = DriveState::kOperationEnabled;
  }
  waits_ = waits_ && !permitted && ready;
}

void CsvDrive::RaiseFault() {
  reset_asked_ = false;
  waits_ = false;
  if (state_ != DriveState::kFault) {
    state_ = DriveState::kFaultReaction;
  }
}

void CsvDrive::Follow(double dt_s, double target_radps, double position_rad,
                      const DriveLimits& limits) {
  const double brake = limits.quick_stop_radps2;
  const double up = std::min(limits.velocity_max_radps,
                             StoppingSpeed(limits.upper_rad - position_rad, brake, dt_s));
  const double down = std::min(limits.velocity_max_radps,
                               StoppingSpeed(position_rad - limits.lower_rad, brake, dt_s));
  internal_limit_ = target_radps < -down || target_radps > up;
  const double ramped =
      Towards(velocity_radps_, std::clamp(target_radps, -down, up), limits.accel_radps2 * dt_s);
  // The limit's own braking is not bound by the acceleration limit.
  velocity_radps_ = Towards(velocity_radps_, std::clamp(ramped, -down, up),
                            std::max(limits.accel_radps2, brake) * dt_s);
}

void CsvDrive::Step(double dt_s, double target_radps, bool mode_is_csv, double position_rad,
                    const DriveLimits& limits) {
  if (dt_s <= 0) {
    return;
  }
  internal_limit_ = false;
  if (state_ == DriveState::kOperationEnabled) {
    Follow(dt_s, mode_is_csv ? target_radps : 0, position_rad, limits);
  } else {
    velocity_radps_ = Towards(velocity_radps_, 0, limits.quick_stop_radps2 * dt_s);
  }

  const bool rests = velocity_radps_ == 0;
  if (state_ == DriveState::kFaultReaction && rests) {
    state_ = DriveState::kFault;
  }
  if (state_ == DriveState::kQuickStopActive && rests &&
      quick_stop_option_ == QuickStopOption::kRampThenDisable) {
    state_ = DriveState::kSwitchOnDisabled;
  }
}

std::uint16_t CsvDrive::Statusword(bool mode_is_csv) const {
  std::uint32_t word = StateBits(state_) | can::statusword::kVoltage | can::statusword::kRemote;
  if (internal_limit_) {
    word |= can::statusword::kInternalLimit;
  }
  if (state_ == DriveState::kOperationEnabled && mode_is_csv) {
    word |= can::statusword::kFollowsCommand;
  }
  return static_cast<std::uint16_t>(word);
}

}  // namespace pipewright::hil
