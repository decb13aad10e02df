// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hil/devices/wheel_slip.h"
#include "platform/can/frame.h"
#include "platform/can/tracer_messages.h"
#include "platform/core/time.h"

namespace pipewright::hil {

/// How this Tracer is built and set. The defaults are the TRACER's where a manual gives a figure;
/// ramps are unpublished and ours.
struct TracerConfig {
  can::ControlModeCodes modes = can::kModesSdk;  ///< the values of 0x211's control mode
  std::uint32_t estop_error = can::base_error::kEmergencyStop;  ///< some bases say 0x0080

  double track_m = 0.35;
  double wheel_radius_m = 0.0605;
  double v_max_mps = 1.8;  ///< commands beyond are clamped (TRACER 2.0)
  double omega_max_radps = 1.0;
  double accel_mps2 = 1.5;
  double alpha_radps2 = 4.0;
  double brake_mps2 = 1.0;  ///< ramp after a lost command
  double brake_radps2 = 3.0;
  double stop_mps2 = 3.0;  ///< servo brake: e-stop, undervoltage
  double stop_radps2 = 8.0;
  Duration command_timeout = std::chrono::milliseconds(500);
  Duration boot_time = std::chrono::milliseconds(100);

  double battery_V = 26.0;
  double charge_percent = 80;

  WheelSlipConfig slip{};  ///< what the wheels, and so 0x221 and 0x311, do not tell

  bool Valid() const;
};

/// The AgileX Tracer as a node on the bus, protocol v2.
///
///   boot -> standby --0x421 01--> CAN --0x111 at least every 500 ms--> moves
///                  <--0x421 00--
///   remote transmitter on: its mode and its sticks win; 0x111 is ignored, lights still work
///   e-stop: vehicle state 1, brakes, 0x421 still accepted; an exception (state 2) latches until
///   0x441 clears it with the cause gone
///
/// Sends 0x211 0x221 0x231 0x241 0x251 0x252 0x311 every 20 ms, 0x261 0x262 every 100 ms, 0x361
/// every 500 ms. Motor 1 is the left wheel, motor 2 the
/// right (the manuals do not say); both turn positive when driving forward.
///
/// Asked for its version, by 0x411 01 (the manual) or 0x4A1 01 (what the vendor's SDK sends), it
/// says 80 ASCII bytes in frames 0x4A1, which is when the SDK stops listening.
class TracerDevice {
 public:
  static constexpr std::uint32_t kVersionRequestId = 0x411;

  explicit TracerDevice(const TracerConfig& config);

  /// Any frame of the bus. Not for us: ignored. For us but malformed: ignored and counted.
  void OnFrame(const can::Frame& frame, Time now);

  /// Moves the device's own time to `now` (ramps, watchdog) and appends the frames due. Call with
  /// steps of at most a few ms.
  void Step(Time now, std::vector<can::Frame>& out);

  /// For the plant.
  BaseMotion motion() const;

  // What a person or the world does to it.
  void PressEmergencyStop(bool pressed) { emergency_stop_ = pressed; }
  void SetRemote(bool on, double v_mps, double omega_radps);
  void SetBattery(double volts, double charge_percent);
  void LoseMotorDriver(int motor, bool lost);  ///< motor 1 or 2; raises an exception
  void Spill(double left, double right) { slip_.Spill(left, right); }  ///< shares of grip lost

  bool can_mode() const { return can_mode_; }
  bool exception() const { return exception_; }
  int watchdog_trips() const { return watchdog_trips_; }
  int rejected() const { return rejected_; }

 private:
  void OnMotionCommand(const can::Frame& frame, Time now);
  void OnLightCommand(const can::Frame& frame);
  void OnModeCommand(const can::Frame& frame);
  void OnReset(const can::Frame& frame);
  void OnVersionRequest(const can::Frame& frame);
  void Drive(double dt_s, Time now);
  void Publish(Time now, std::vector<can::Frame>& out);
  void PublishFast(std::vector<can::Frame>& out);
  void PublishSlow(std::vector<can::Frame>& out) const;
  void PublishVersion(std::vector<can::Frame>& out);
  double LeftWheel_mps() const;
  double RightWheel_mps() const;
  bool Powered() const;
  std::uint32_t ErrorBits() const;
  can::ControlMode Mode() const;

  TracerConfig config_;
  WheelSlip slip_;
  std::optional<Time> booted_;
  Time last_{};
  Time next_fast_{};
  Time next_slow_{};
  Time next_bms_{};
  std::optional<Time> last_command_;
  bool can_mode_ = false;
  bool timed_out_ = false;
  bool emergency_stop_ = false;
  bool exception_ = false;
  bool undervoltage_ = false;
  bool remote_on_ = false;
  bool motor_lost_[2] = {false, false};
  double remote_v_mps_ = 0;
  double remote_omega_radps_ = 0;
  double target_v_mps_ = 0;
  double target_omega_radps_ = 0;
  double v_mps_ = 0;  ///< of the wheels
  double omega_radps_ = 0;
  double left_m_ = 0;
  double right_m_ = 0;
  can::BaseLight lights_;
  std::uint8_t count_state_ = 0;
  std::uint8_t count_light_ = 0;
  std::uint8_t count_remote_ = 0;
  int version_said_ = 0;        ///< bytes of it
  bool version_asked_ = false;  ///< and not yet said to its end
  int watchdog_trips_ = 0;
  int rejected_ = 0;
};

}  // namespace pipewright::hil
