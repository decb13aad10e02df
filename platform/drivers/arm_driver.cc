// SPDX-License-Identifier: MIT
#include "platform/drivers/arm_driver.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <type_traits>

#include "platform/can/error_frame.h"

namespace pipewright {
namespace {

using can::DriveState;
using can::kArmNodes;
using can::NmtState;

constexpr Duration kHeartbeatPeriod = std::chrono::milliseconds(can::kHeartbeatPeriod_ms);

bool Powered(DriveState state) {
  return state == DriveState::kOperationEnabled || state == DriveState::kQuickStopActive ||
         state == DriveState::kFaultReaction;
}

}  // namespace

ArmDriver::ArmDriver(const ArmDriverConfig& config) : config_(config) { assert(config.Valid()); }

void ArmDriver::OnFrame(const can::Frame& frame) {
  const bool at_work = phase_ == DriverPhase::kWaiting || phase_ == DriverPhase::kConfiguring ||
                       phase_ == DriverPhase::kEnabling || phase_ == DriverPhase::kReady;
  if (can::TellsBusOff(frame) && at_work) {
    Fail(Status::kUnavailable, Problem::kBusOff, 0, frame.id);
  }
  const auto take = [&](const can::FrameHead& head, const auto& msg, int id) {
    using Msg = std::decay_t<decltype(msg)>;
    if (id < 1 || id > kArmNodes) {
      return;
    }
    Node& node = nodes_[id - 1];
    if constexpr (std::is_same_v<Msg, can::JointFeedback>) {
      OnFeedback(id, msg, frame.stamp);
    } else if constexpr (std::is_same_v<Msg, can::JointStatus>) {
      node.statusword = msg.statusword;
      node.drive = can::StateOf(msg.statusword);
      node.mode = msg.mode;
      Latch(node);
    } else if constexpr (std::is_same_v<Msg, can::Heartbeat>) {
      OnHeartbeat(node, msg, frame.stamp);
      Latch(node);
    } else if constexpr (std::is_same_v<Msg, can::Emergency>) {
      node.emergency = ready() && msg.code == can::emergency::kNone ? node.emergency : msg.code;
    } else if constexpr (std::is_same_v<Msg, can::Sdo>) {
      if (head.id == can::kSdoResponse.head.id) {
        OnSdo(node, id, can::Meaning(msg, true));
      }
    }
  };
  // Refused frames are in rx_; what stays away then is what the ages in CheckAges see.
  (void)can::Dispatch(can::kArmTable, frame, rx_, take);
}

void ArmDriver::OnFeedback(int id, const can::JointFeedback& feedback, Time stamp) {
  Node& node = nodes_[id - 1];
  if (node.has_feedback && stamp < node.feedback_at) {
    ++late_;
    return;
  }
  if (!Likely(id, feedback, stamp)) {
    ++unlikely_;
    return;
  }
  position_rad_[id - 1] = feedback.position_rad;
  velocity_radps_[id - 1] = feedback.velocity_radps;
  node.feedback_at = stamp;
  node.has_feedback = true;
}

bool ArmDriver::Likely(int id, const can::JointFeedback& feedback, Time stamp) const {
  if (!ready()) {
    return true;
  }
  const double slack_s = 2e-3 * config_.cycle_ms;
  const double time_s = ToSeconds(stamp - nodes_[id - 1].feedback_at) + slack_s;
  const double way_rad = std::abs(feedback.position_rad - position_rad_[id - 1]);
  return way_rad <= can::kJointSpeedLimit_radps * time_s &&
         std::abs(feedback.velocity_radps) <= 2 * can::kJointSpeedLimit_radps;
}

/// What a drive at work says once counts, whatever it says before the next Step.
void ArmDriver::Latch(Node& node) {
  if (!ready()) {
    return;
  }
  const bool failed = node.drive == DriveState::kFault || node.drive == DriveState::kFaultReaction;
  node.drive_failed = node.drive_failed || failed;
  node.control_lost = node.control_lost || node.drive != DriveState::kOperationEnabled ||
                      !node.operational || node.mode != can::kModeCyclicVelocity;
}

void ArmDriver::OnHeartbeat(Node& node, const can::Heartbeat& heartbeat, Time stamp) {
  const auto state = static_cast<NmtState>(heartbeat.state);
  node.heartbeat_at = stamp;
  node.operational = state == NmtState::kOperational;
  if (state != NmtState::kBootUp) {
    return;
  }
  node.rebooted = true;  // its parameters are gone
  node.step = 0;
  node.asked = false;
}

Status ArmDriver::Command(const ArmVector& velocity_radps) {
  commanded_ = false;
  if (!ready()) {
    return Status::kUnavailable;
  }
  for (int i = 0; i < kArmNodes; ++i) {
    if (!(std::abs(velocity_radps[i]) <= can::kJointSpeedLimit_radps)) {
      return Status::kOutOfRange;
    }
  }
  command_radps_ = velocity_radps;
  commanded_ = true;
  return Status::kOk;
}

void ArmDriver::Step(Time now, TxBatch& out) {
  if (!started_) {
    started_ = true;
    Enter(DriverPhase::kWaiting, now);
    SendNmt(can::NmtCommand::kPreOperational, out);
  }
  if (stop_requested_) {
    stop_requested_ = false;
    Enter(pdos_active_ ? DriverPhase::kStopping : DriverPhase::kStopped, now);
  }
  SendHeartbeat(now, out);
  switch (phase_) {
    case DriverPhase::kWaiting:
      StepWaiting(now, out);
      break;
    case DriverPhase::kConfiguring:
      StepConfiguring(now, out);
      break;
    case DriverPhase::kEnabling:
      StepEnabling(now, out);
      break;
    case DriverPhase::kReady:
      StepReady(now, out);
      break;
    case DriverPhase::kStopping:
      StepStopping(now, out);
      break;
    case DriverPhase::kStopped:
      SendToAll(can::controlword::kDisableVoltage, ArmVector::Zero(), out);
      break;
    case DriverPhase::kFault:
      SendToAll(can::controlword::kQuickStop, ArmVector::Zero(), out);
      break;
  }
  commanded_ = false;
}

void ArmDriver::StepReady(Time now, TxBatch& out) {
  for (int id = 1; id <= kArmNodes && phase_ == DriverPhase::kReady; ++id) {
    Latch(nodes_[id - 1]);
    CheckEnabled(id, nodes_[id - 1]);
  }
  for (int id = 1; id <= kArmNodes && phase_ == DriverPhase::kReady; ++id) {
    CheckAges(id, nodes_[id - 1], now);
  }
  if (phase_ == DriverPhase::kReady) {
    SendToAll(can::controlword::kEnableOperation, commanded_ ? command_radps_ : ArmVector::Zero(),
              out);
  } else {
    SendToAll(can::controlword::kQuickStop, ArmVector::Zero(), out);
  }
}

void ArmDriver::CheckEnabled(int id, const Node& node) {
  if (node.rebooted) {
    Fail(Status::kFault, Problem::kRebooted, id, 0);
  } else if (node.emergency != can::emergency::kNone) {
    Fail(Status::kFault, Problem::kEmergencyMessage, id, node.emergency);
  } else if (node.drive_failed) {
    Fail(Status::kFault, Problem::kDriveFault, id, node.emergency);
  } else if (node.control_lost) {
    Fail(Status::kFault, Problem::kControlLost, id, node.statusword);
  }
}

void ArmDriver::CheckAges(int id, const Node& node, Time now) {
  const Problem problem = AgeProblem(now, node.feedback_at, config_.feedback_timeout);
  if (problem != Problem::kNone) {
    Fail(Status::kStale, problem, id, 0);
  } else if (now - node.heartbeat_at > config_.heartbeat_timeout) {
    Fail(Status::kStale, Problem::kHeartbeatLost, id, 0);
  }
}

void ArmDriver::StepStopping(Time now, TxBatch& out) {
  if (!disabling_) {
    SendToAll(can::controlword::kEnableOperation, ArmVector::Zero(), out);
    if (velocity_radps_.cwiseAbs().maxCoeff() <= config_.standstill_radps ||
        now - phase_start_ > config_.rest_timeout) {
      disabling_ = true;
      phase_start_ = now;
    }
    return;
  }
  std::array<std::uint32_t, kArmNodes> words{};
  bool powered = false;
  for (int i = 0; i < kArmNodes; ++i) {
    powered = powered || Powered(nodes_[i].drive);
    words[i] = nodes_[i].drive == DriveState::kOperationEnabled ? can::controlword::kQuickStop
                                                                : can::controlword::kDisableVoltage;
  }
  SendWords(words, ArmVector::Zero(), out);
  if (!powered || now - phase_start_ > config_.disable_timeout) {
    Enter(DriverPhase::kStopped, now);
  }
}

void ArmDriver::SendToAll(std::uint32_t word, const ArmVector& velocity, TxBatch& out) {
  std::array<std::uint32_t, kArmNodes> words{};
  words.fill(word);
  SendWords(words, velocity, out);
}

void ArmDriver::SendWords(const std::array<std::uint32_t, kArmNodes>& words,
                          const ArmVector& velocity, TxBatch& out) {
  if (!pdos_active_) {
    return;
  }
  for (int i = 0; i < kArmNodes; ++i) {
    nodes_[i].sent_word = words[i];
    Send(
        Encode(can::kJointCommand, {.controlword = words[i], .velocity_radps = velocity[i]}, i + 1),
        out);
  }
  Send(Encode(can::kSync, {}), out);  // last: the drives act on the words above, and sample
}

void ArmDriver::SendNmt(can::NmtCommand command, TxBatch& out) {
  Send(Encode(can::kNmt, {.command = static_cast<std::uint32_t>(command), .node = 0}), out);
}

void ArmDriver::SendHeartbeat(Time now, TxBatch& out) {
  // Not due yet; where the clock was set back, it is.
  if (now < next_heartbeat_ && next_heartbeat_ - now <= kHeartbeatPeriod) {
    return;
  }
  Send(Encode(can::kHeartbeat, {.state = static_cast<std::uint32_t>(NmtState::kOperational)},
              can::kHostNode),
       out);
  next_heartbeat_ = now + kHeartbeatPeriod;
}

void ArmDriver::Send(const Result<can::Frame>& frame, TxBatch& out) {
  if (!frame.ok() || !out.push_back(*frame)) {
    ++tx_dropped_;
  }
}

void ArmDriver::Stop() {
  stop_requested_ = phase_ != DriverPhase::kStopped && phase_ != DriverPhase::kFault;
}

void ArmDriver::Reset() {
  const can::RxCounters rx = rx_;
  const std::uint64_t late = late_;
  const std::uint64_t unlikely = unlikely_;
  const int tx_dropped = tx_dropped_;
  *this = ArmDriver(config_);
  rx_ = rx;
  late_ = late;
  unlikely_ = unlikely;
  tx_dropped_ = tx_dropped;
}

void ArmDriver::Enter(DriverPhase phase, Time now) {
  phase_ = phase;
  phase_start_ = now;
}

void ArmDriver::Fail(Status status, Problem problem, int node, std::uint32_t detail) {
  fault_ = {status, problem, node, detail};
  phase_ = DriverPhase::kFault;
}

bool ArmDriver::has_feedback() const {
  return std::all_of(nodes_.begin(), nodes_.end(), [](const Node& n) { return n.has_feedback; });
}

Time ArmDriver::feedback_stamp() const {
  Time oldest = nodes_[0].feedback_at;
  for (const Node& node : nodes_) {
    oldest = std::min(oldest, node.feedback_at);
  }
  return oldest;
}

}  // namespace pipewright
