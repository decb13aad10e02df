// SPDX-License-Identifier: MIT
#pragma once

#include "platform/can/tracer.h"
#include "platform/core/time.h"
#include "platform/core/usable.h"
#include "platform/drivers/device_fault.h"

namespace pipewright {

struct TracerDriverConfig {
  can::ControlModeCodes mode_codes = can::kModesSdk;
  Duration start_timeout = std::chrono::seconds(5);   ///< for 0x211 and 0x221 to be heard
  Duration enable_timeout = std::chrono::seconds(2);  ///< for 0x211 to say CAN mode
  Duration request_period = std::chrono::milliseconds(100);
  Duration command_period = std::chrono::milliseconds(20);
  Duration state_timeout = std::chrono::milliseconds(100);  ///< five periods of 0x211 and 0x221
  Duration stop_timeout = std::chrono::seconds(2);
  double standstill_mps = 0.002;  ///< two units of 0x221
  double standstill_radps = 0.002;

  constexpr bool Valid() const {
    return Usable(start_timeout) && Usable(enable_timeout) && Usable(request_period) &&
           Usable(command_period) && Usable(state_timeout) && Usable(stop_timeout) &&
           Usable({standstill_mps, standstill_radps}) && command_period > Duration::zero() &&
           4 * command_period < can::kTracerCommandTimeout && request_period > Duration::zero() &&
           state_timeout >= std::chrono::milliseconds(40) && start_timeout > Duration::zero() &&
           enable_timeout > request_period && stop_timeout > Duration::zero() &&
           standstill_mps > 0 && standstill_radps > 0;
  }
};
static_assert(TracerDriverConfig{}.Valid());

/// The host's side of the Tracer base. Pure: fed frames and time, heap-free.
///
///   kWaiting    until 0x211 and 0x221 have come
///   kEnabling   0x421 01 every 100 ms until 0x211 says CAN mode
///   kReady      0x111 every 20 ms
///   kFault      latched; zero speed is sent for as long as the base may listen
///
/// A trouble that a frame tells of latches though it is over before the next Step.
///
///   Frame frame;
///   while (port.Receive(frame)) driver.OnFrame(frame);
///   if (driver.ready()) driver.Command(v, omega);        // every cycle, or zero is sent
///   driver.Step(now, out);
///   for (const can::Frame& f : out) port.Send(f);
class TracerDriver {
 public:
  explicit TracerDriver(const TracerDriverConfig& config = {});

  /// Any frame of the bus; its stamp counts. What is not the base's, and what is older than a
  /// frame of its kind that came before, is counted and ignored. Bus-off latches.
  void OnFrame(const can::Frame& frame);

  /// The twist that the next Step may send: v [m/s], omega [rad/s]. kOutOfRange: outside the limits
  /// of 0x111 or not finite; kUnavailable: not ready. Then zero is sent.
  Status Command(double v_mps, double omega_radps);

  /// Moves to `now` and appends what is due.
  void Step(Time now, TxBatch& out);

  void Stop();   ///< brings the base to rest and hands control back (0x421 00)
  void Reset();  ///< an operator's word: forget the fault, start again

  DriverPhase phase() const { return phase_; }
  bool ready() const { return phase_ == DriverPhase::kReady; }
  const DeviceFault& fault() const { return fault_; }

  const can::BaseTwist& twist() const { return twist_; }
  Time twist_stamp() const { return twist_stamp_; }
  const can::BaseOdometer& odometer() const { return odometer_; }
  Time odometer_stamp() const { return odometer_stamp_; }
  bool has_odometer() const { return has_odometer_; }
  const can::BaseState& state() const { return state_; }
  Time state_stamp() const { return state_stamp_; }
  double battery_V() const { return can::BatteryVolts(state_); }
  bool emergency_stop() const;
  const can::RxCounters& rx_counters() const { return rx_; }
  std::uint64_t late() const { return late_; }    ///< frames older than one before them
  int tx_dropped() const { return tx_dropped_; }  ///< frames for which `out` had no room

 private:
  bool InOrder(bool has, Time newest, Time stamp);
  void StepWaiting(Time now);
  void StepEnabling(Time now, TxBatch& out);
  void StepStopping(Time now, TxBatch& out);
  void CheckReport();
  void CheckAges(Time now);
  void SendTwist(Time now, TxBatch& out);
  void Send(const Result<can::Frame>& frame, TxBatch& out);
  void Enter(DriverPhase phase, Time now);
  void Fail(Status status, Problem problem, std::uint32_t detail);

  TracerDriverConfig config_;
  DriverPhase phase_ = DriverPhase::kWaiting;
  DeviceFault fault_;
  Time phase_start_{};
  bool started_ = false;
  bool stop_requested_ = false;
  bool has_state_ = false;
  bool has_twist_ = false;
  bool has_odometer_ = false;
  can::BaseState state_;
  can::BaseTwist twist_;
  can::BaseOdometer odometer_;
  Time state_stamp_{};
  Time twist_stamp_{};
  Time odometer_stamp_{};
  can::BaseTwistCommand command_;
  bool commanded_ = false;
  Time next_twist_{};
  Time next_request_{};
  can::RxCounters rx_;
  std::uint64_t late_ = 0;
  int tx_dropped_ = 0;
};

}  // namespace pipewright
