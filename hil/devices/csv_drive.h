// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "platform/can/cia402_state.h"

namespace pipewright::hil {

/// What a drive obeys. Units: rad, s.
struct DriveLimits {
  double velocity_max_radps = 3.14159265358979;
  double accel_radps2 = 20.0;       ///< 60C5h
  double quick_stop_radps2 = 10.0;  ///< 6085h
  double lower_rad = -6.2831;       ///< 607Dh, soft
  double upper_rad = 6.2831;
};

using can::DriveState;

/// 605Ah, the values this drive knows.
enum class QuickStopOption : std::int16_t { kRampThenDisable = 2, kRampThenStay = 6 };

/// One joint's CiA 402 drive in cyclic synchronous velocity mode, without a bus: the state machine
/// and the velocity ramp.
///
///   velocity -> target at |a| <= accel, |velocity| <= velocity_max, and slow enough to stop at a
///   soft limit with the quick-stop ramp (internal limit, statusword bit 11)
///
/// In every state but operation enabled the brake holds: a joint still turning is brought to rest
/// on the quick-stop ramp.
class CsvDrive {
 public:
  /// Leaves kNotReady for kSwitchOnDisabled: the self-test is over.
  void PowerUp();
  /// Back to kNotReady. A joint that turns is braked, not stopped dead.
  void Restart();

  /// One controlword (6040h). Bits 0-3 are the command, a rising bit 7 resets a fault.
  void Command(std::uint16_t controlword);

  /// Begins the fault reaction (605Eh = 2: ramp, then fault).
  void RaiseFault();
  /// Set while a fault's cause persists: it cannot be reset then.
  void HoldFault(bool cause_persists) { fault_held_ = cause_persists; }

  /// For a power stage that has a start-up of its own: until it is permitted (from the start it is)
  /// a drive that is told to enable operation stays switched on, and does so then. What is enabled
  /// already stays so.
  void PermitOperation(bool permitted);

  /// dt_s of motion towards `target_radps` (60FFh) from the position the joint really has.
  void Step(double dt_s, double target_radps, bool mode_is_csv, double position_rad,
            const DriveLimits& limits);

  void set_quick_stop_option(QuickStopOption option) { quick_stop_option_ = option; }

  DriveState state() const { return state_; }
  /// Told to enable operation, and waiting for the permission.
  bool waits() const { return waits_; }
  /// A reset was asked for since the last RaiseFault(), while the fault was held.
  bool reset_asked() const { return reset_asked_; }
  double velocity_radps() const { return velocity_radps_; }
  /// 6041h. Bit 12, the drive follows 60FFh, needs the mode.
  std::uint16_t Statusword(bool mode_is_csv) const;

 private:
  void Follow(double dt_s, double target_radps, double position_rad, const DriveLimits& limits);

  DriveState state_ = DriveState::kNotReady;
  QuickStopOption quick_stop_option_ = QuickStopOption::kRampThenDisable;
  double velocity_radps_ = 0;
  std::uint16_t controlword_ = 0;
  bool fault_held_ = false;
  bool reset_asked_ = false;
  bool permitted_ = true;
  bool waits_ = false;
  bool internal_limit_ = false;
};

}  // namespace pipewright::hil
