// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

/// What the frames of an AgileX Tracer (CAN protocol v2) say; tracer.h has their rows.
namespace pipewright::can {

/// Twist of base B in odometry frame W, expressed in B: x forward, omega anticlockwise.
struct BaseTwistCommand {
  double v_mps = 0;
  double omega_radps = 0;
};

struct BaseTwist {
  double v_mps = 0;
  double omega_radps = 0;
  double lateral_mps = 0;   ///< 0 on a Tracer
  double steering_rad = 0;  ///< 0 on a Tracer
};

/// Command and state have one layout. Modes: 0 off, 1 on, 2 breathing, 3 custom brightness.
struct BaseLight {
  std::uint32_t enabled = 0;
  std::uint32_t front_mode = 0;
  double front_percent = 0;
  std::uint32_t rear_mode = 0;  ///< 0 on a Tracer
  double rear_percent = 0;      ///< 0 on a Tracer
  std::uint32_t count = 0;
};

struct BaseState {
  std::uint32_t vehicle_state = 0;  ///< VehicleState
  std::uint32_t control_mode = 0;   ///< by ControlModeCodes
  double battery_V = 0;             ///< some firmware sends tenfold; see BatteryVolts
  std::uint32_t errors = 0;         ///< base_error bits
  std::uint32_t count = 0;          ///< rolls over at 256
};

/// Switches: 2 up, 3 down (swb: 1 middle). Sticks in percent.
struct BaseRemote {
  std::uint32_t swa = 0;
  std::uint32_t swb = 0;
  std::uint32_t swc = 0;
  std::uint32_t swd = 0;
  double right_horizontal = 0;
  double right_vertical = 0;
  double left_vertical = 0;
  double left_horizontal = 0;
  double variable_a = 0;
  std::uint32_t count = 0;
};

struct BaseMotorFast {
  double speed_rpm = 0;  ///< the one non-SI unit: gear and wheel are not in the protocol
  double current_A = 0;
  double pulses = 0;
};

struct BaseMotorSlow {
  double driver_V = 0;
  double driver_degC = 0;
  double motor_degC = 0;
  std::uint32_t driver_state = 0;  ///< b2 over-current, b4 CAN lost, b6 enabled
};

/// Distance that each wheel's circumference has rolled since power-up.
struct BaseOdometer {
  double left_m = 0;
  double right_m = 0;
};

struct BaseBattery {
  double charge_percent = 0;
  double health_percent = 0;
  double voltage_V = 0;
  double current_A = 0;
  double temperature_degC = 0;
};

struct BaseModeRequest {
  std::uint32_t mode = 0;  ///< 0 standby or remote, 1 CAN, 2 serial
};

struct BaseErrorReset {
  std::uint32_t what = 0;  ///< 0 all, 1 motor 1, 2 motor 2
};

/// Eight of the 80 ASCII characters of the base's version, which come in ten of these frames.
struct BaseVersion {
  std::uint32_t text_1 = 0;
  std::uint32_t text_2 = 0;
  std::uint32_t text_3 = 0;
  std::uint32_t text_4 = 0;
  std::uint32_t text_5 = 0;
  std::uint32_t text_6 = 0;
  std::uint32_t text_7 = 0;
  std::uint32_t text_8 = 0;
};

/// BaseState::vehicle_state.
enum class VehicleState : std::uint8_t { kNormal = 0, kEmergencyStop = 1, kException = 2 };

enum class ControlMode : std::uint8_t { kStandby, kCan, kSerial, kRemote, kUnknown };

/// What the values 0 to 3 of BaseState::control_mode mean; the sources differ by product and year.
struct ControlModeCodes {
  std::string_view source;
  std::array<ControlMode, 4> meaning;

  constexpr ControlMode Meaning(std::uint32_t code) const {
    return code < meaning.size() ? meaning[code] : ControlMode::kUnknown;
  }
  /// The value that says `mode`, or 0 when this table has none.
  constexpr std::uint32_t Code(ControlMode mode) const {
    for (std::uint32_t code = 0; code < meaning.size(); ++code) {
      if (meaning[code] == mode) {
        return code;
      }
    }
    return 0;
  }
};

inline constexpr ControlModeCodes kModesTracer12{
    "TRACER manual v1.2",
    {ControlMode::kRemote, ControlMode::kCan, ControlMode::kSerial, ControlMode::kUnknown}};
inline constexpr ControlModeCodes kModesTracer20{
    "TRACER 2.0 manual",
    {ControlMode::kStandby, ControlMode::kCan, ControlMode::kRemote, ControlMode::kUnknown}};
inline constexpr ControlModeCodes kModesMini{
    "TRACER MINI manual",
    {ControlMode::kStandby, ControlMode::kCan, ControlMode::kSerial, ControlMode::kRemote}};
inline constexpr ControlModeCodes kModesSdk{
    "vendor's SDK, and a real Mini Bunker",
    {ControlMode::kStandby, ControlMode::kCan, ControlMode::kSerial, ControlMode::kRemote}};

/// Bits of BaseState::errors (payload byte 4 is the high one).
namespace base_error {
inline constexpr std::uint32_t kDriverAbnormal = 1U << 0;
inline constexpr std::uint32_t kUndervoltage = 1U << 8;  ///< below 22 V: the drives are unpowered
inline constexpr std::uint32_t kUndervoltageWarning = 1U << 9;  ///< below 22.5 V
inline constexpr std::uint32_t kRemoteLost = 1U << 10;
inline constexpr std::uint32_t kMotor1Lost = 1U << 11;
inline constexpr std::uint32_t kMotor2Lost = 1U << 14;
inline constexpr std::uint32_t kEmergencyStop = 1U << 15;
}  // namespace base_error

/// The battery is a 24 V one; some firmware sends 0x211 in steps of 0.01 V, read here tenfold.
constexpr double BatteryVolts(const BaseState& state) {
  return state.battery_V > 40 ? state.battery_V / 10 : state.battery_V;
}

}  // namespace pipewright::can
