// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "platform/can/arm_startup.h"
#include "platform/core/time.h"
#include "platform/core/usable.h"
#include "platform/drivers/device_fault.h"
#include "platform/robot/robot.h"

namespace pipewright {

struct ArmDriverConfig {
  int cycle_ms = can::kArmCycle_ms;                       ///< between two Steps; told to the drives
  Duration start_timeout = std::chrono::seconds(5);       ///< for all seven to answer
  Duration sdo_timeout = std::chrono::milliseconds(200);  ///< of one request
  int sdo_tries = 3;
  Duration enable_timeout = std::chrono::seconds(3);
  Duration feedback_timeout = std::chrono::milliseconds(50);  ///< of TPDO1
  Duration heartbeat_timeout = std::chrono::milliseconds(300);
  Duration rest_timeout = std::chrono::milliseconds(500);  ///< stopping: to come to rest
  Duration disable_timeout = std::chrono::seconds(1);      ///< stopping: to be disabled
  double standstill_radps = 1e-3;

  constexpr bool Valid() const {
    return Usable(start_timeout) && Usable(sdo_timeout) && Usable(enable_timeout) &&
           Usable(feedback_timeout) && Usable(heartbeat_timeout) && Usable(rest_timeout) &&
           Usable(disable_timeout) && Usable(standstill_radps) && cycle_ms >= 1 && cycle_ms <= 50 &&
           start_timeout > Duration::zero() && sdo_timeout > Duration::zero() && sdo_tries > 0 &&
           enable_timeout > Duration::zero() &&
           feedback_timeout >= std::chrono::milliseconds(2 * cycle_ms) &&
           heartbeat_timeout >= std::chrono::milliseconds(2 * can::kHeartbeatPeriod_ms) &&
           rest_timeout > Duration::zero() && disable_timeout > Duration::zero() &&
           standstill_radps > 0;
  }
};
static_assert(ArmDriverConfig{}.Valid());

/// The host's side of the arm: seven CiA 402 drives. Pure: fed frames and time, heap-free.
///
///   kWaiting      all to pre-operational, then each probed (object 1000h) until it answers
///   kConfiguring  can::kArmStartup, one request at a time a drive
///   kEnabling     NMT start, then 06, 07, 0F by RPDO1 at each SYNC until all are enabled
///   kReady        each Step: seven RPDO1, then SYNC, at which they act and TPDO1 is sampled
///   kStopping     zero velocity, at rest quick stop, then voltage off
///   kFault        latched: quick stop to all at each SYNC
///
/// A trouble that a frame tells of latches though it is over before the next Step.
///
///   Frame frame;
///   while (port.Receive(frame)) driver.OnFrame(frame);   // feedback of the SYNC one cycle ago
///   if (driver.ready()) driver.Command(qdot);            // every cycle, or zero is sent
///   driver.Step(now, out);
///   for (const can::Frame& f : out) port.Send(f);        // in this order
class ArmDriver {
 public:
  explicit ArmDriver(const ArmDriverConfig& config = {});

  /// Any frame of the bus; its stamp counts. What is not the arm's, and a reading that is late() or
  /// unlikely(), is counted and ignored. Bus-off latches.
  void OnFrame(const can::Frame& frame);

  /// Joint velocities [rad/s] until the next Step. kOutOfRange: one is outside the limits of RPDO1
  /// or not finite; kUnavailable: not ready. Then zero is sent.
  Status Command(const ArmVector& velocity_radps);

  /// One control cycle: moves to `now` and appends what is due, at most 10 frames.
  void Step(Time now, TxBatch& out);

  void Stop();   ///< brings the arm to rest and disables it
  void Reset();  ///< an operator's word: forget the fault, start again

  DriverPhase phase() const { return phase_; }
  bool ready() const { return phase_ == DriverPhase::kReady; }
  const DeviceFault& fault() const { return fault_; }

  const ArmVector& position_rad() const { return position_rad_; }
  const ArmVector& velocity_radps() const { return velocity_radps_; }
  /// Time of the oldest of the seven readings; Time{} before all have come.
  Time feedback_stamp() const;
  bool has_feedback() const;
  can::DriveState drive_state(int joint) const { return nodes_[joint].drive; }  ///< 0 to 6
  std::uint32_t last_emergency(int joint) const { return nodes_[joint].emergency; }
  const can::RxCounters& rx_counters() const { return rx_; }
  std::uint64_t late() const { return late_; }  ///< readings older than one before them
  /// Readings that no joint can have after the one before: it would have moved faster than its
  /// limit for two cycles longer than the time between them. Ignored; the state then grows stale.
  std::uint64_t unlikely() const { return unlikely_; }
  int tx_dropped() const { return tx_dropped_; }  ///< frames for which `out` had no room

 private:
  struct Node {
    bool answered = false;
    int step = 0;  ///< in can::kArmStartup
    bool asked = false;
    Time asked_at{};
    int tries = 0;
    bool operational = false;
    bool rebooted = false;
    bool drive_failed = false;  ///< while ready, as the next
    bool control_lost = false;
    bool has_feedback = false;
    Time heartbeat_at{};
    Time feedback_at{};
    can::DriveState drive = can::DriveState::kUnknown;
    std::uint32_t statusword = 0;
    std::uint32_t mode = 0;
    std::uint32_t emergency = 0;  ///< while ready: the last that was not "no error"
    std::uint32_t sent_word = 0;
  };

  void OnHeartbeat(Node& node, const can::Heartbeat& heartbeat, Time stamp);
  void OnFeedback(int id, const can::JointFeedback& feedback, Time stamp);
  bool Likely(int id, const can::JointFeedback& feedback, Time stamp) const;
  void Latch(Node& node);
  void OnSdo(Node& node, int id, const can::SdoMeaning& sdo);
  void StepWaiting(Time now, TxBatch& out);
  void StepConfiguring(Time now, TxBatch& out);
  bool AskNext(Node& node, int id, Time now, TxBatch& out);
  void StepEnabling(Time now, TxBatch& out);
  void StepReady(Time now, TxBatch& out);
  void StepStopping(Time now, TxBatch& out);
  void CheckEnabled(int id, const Node& node);
  void CheckAges(int id, const Node& node, Time now);
  void SendWords(const std::array<std::uint32_t, can::kArmNodes>& words, const ArmVector& velocity,
                 TxBatch& out);
  void SendToAll(std::uint32_t word, const ArmVector& velocity, TxBatch& out);
  void SendNmt(can::NmtCommand command, TxBatch& out);
  void SendHeartbeat(Time now, TxBatch& out);
  void Send(const Result<can::Frame>& frame, TxBatch& out);
  void Enter(DriverPhase phase, Time now);
  void Fail(Status status, Problem problem, int node, std::uint32_t detail);
  /// The value that `step` has for drive `id` in this configuration.
  std::uint32_t ValueOf(const can::StartupStep& step, int id) const;

  ArmDriverConfig config_;
  DriverPhase phase_ = DriverPhase::kWaiting;
  DeviceFault fault_;
  Time phase_start_{};
  bool started_ = false;
  bool stop_requested_ = false;
  bool pdos_active_ = false;  ///< the drives have been started: they listen to RPDO1 and SYNC
  bool disabling_ = false;
  std::array<Node, can::kArmNodes> nodes_;
  ArmVector position_rad_ = ArmVector::Zero();
  ArmVector velocity_radps_ = ArmVector::Zero();
  ArmVector command_radps_ = ArmVector::Zero();
  bool commanded_ = false;
  Time next_heartbeat_{};
  Time next_request_{};
  can::RxCounters rx_;
  std::uint64_t late_ = 0;
  std::uint64_t unlikely_ = 0;
  int tx_dropped_ = 0;
};

}  // namespace pipewright
