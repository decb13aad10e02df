// SPDX-License-Identifier: MIT
#include "platform/drivers/tracer_driver.h"

#include <cassert>
#include <cmath>
#include <type_traits>

#include "platform/can/error_frame.h"

namespace pipewright {
namespace {

using can::ControlMode;
using can::VehicleState;

constexpr std::uint32_t kRequestStandby = 0;
constexpr std::uint32_t kRequestCan = 1;

constexpr double kMaxV_mps = can::kBaseTwistCommand.signals[0].max;
constexpr double kMaxOmega_radps = can::kBaseTwistCommand.signals[1].max;

VehicleState StateOf(const can::BaseState& state) {
  return static_cast<VehicleState>(state.vehicle_state);
}

}  // namespace

TracerDriver::TracerDriver(const TracerDriverConfig& config) : config_(config) {
  assert(config.Valid());
}

void TracerDriver::OnFrame(const can::Frame& frame) {
  const bool at_work = phase_ == DriverPhase::kWaiting || phase_ == DriverPhase::kEnabling ||
                       phase_ == DriverPhase::kReady;
  if (can::TellsBusOff(frame) && at_work) {
    Fail(Status::kUnavailable, Problem::kBusOff, frame.id);
  }
  const auto take = [&](const can::FrameHead&, const auto& msg, int) {
    using Msg = std::decay_t<decltype(msg)>;
    if constexpr (std::is_same_v<Msg, can::BaseState>) {
      if (InOrder(has_state_, state_stamp_, frame.stamp)) {
        state_ = msg;
        state_stamp_ = frame.stamp;
        has_state_ = true;
        CheckReport();
      }
    } else if constexpr (std::is_same_v<Msg, can::BaseTwist>) {
      if (InOrder(has_twist_, twist_stamp_, frame.stamp)) {
        twist_ = msg;
        twist_stamp_ = frame.stamp;
        has_twist_ = true;
      }
    } else if constexpr (std::is_same_v<Msg, can::BaseOdometer>) {
      if (InOrder(has_odometer_, odometer_stamp_, frame.stamp)) {
        odometer_ = msg;
        odometer_stamp_ = frame.stamp;
        has_odometer_ = true;
      }
    }
  };
  // Refused frames are in rx_; what stays away then is what the ages below see.
  (void)can::Dispatch(can::kTracerTable, frame, rx_, take);
}

bool TracerDriver::InOrder(bool has, Time newest, Time stamp) {
  const bool in_order = !has || stamp >= newest;
  late_ += in_order ? 0 : 1;
  return in_order;
}

Status TracerDriver::Command(double v_mps, double omega_radps) {
  commanded_ = false;
  if (!ready()) {
    return Status::kUnavailable;
  }
  if (!(std::abs(v_mps) <= kMaxV_mps && std::abs(omega_radps) <= kMaxOmega_radps)) {
    return Status::kOutOfRange;
  }
  command_ = {v_mps, omega_radps};
  commanded_ = true;
  return Status::kOk;
}

void TracerDriver::Step(Time now, TxBatch& out) {
  if (!started_) {
    started_ = true;
    Enter(DriverPhase::kWaiting, now);
  }
  if (stop_requested_) {
    stop_requested_ = false;
    Enter(has_state_ ? DriverPhase::kStopping : DriverPhase::kStopped, now);
  }
  CheckReport();
  CheckAges(now);
  switch (phase_) {
    case DriverPhase::kWaiting:
      StepWaiting(now);
      break;
    case DriverPhase::kConfiguring:  // a Tracer has nothing to configure
    case DriverPhase::kEnabling:
      StepEnabling(now, out);
      break;
    case DriverPhase::kStopping:
      StepStopping(now, out);
      break;
    case DriverPhase::kReady:
    case DriverPhase::kFault:
    case DriverPhase::kStopped:
      break;
  }
  const bool streams = phase_ == DriverPhase::kReady || phase_ == DriverPhase::kStopping ||
                       phase_ == DriverPhase::kFault;
  if (streams && has_state_) {
    SendTwist(now, out);
  }
  commanded_ = false;
}

void TracerDriver::StepWaiting(Time now) {
  if (has_state_ && has_twist_) {
    Enter(DriverPhase::kEnabling, now);
  } else if (now - phase_start_ > config_.start_timeout) {
    Fail(Status::kTimeout, Problem::kNotHeard, 0);
  }
}

void TracerDriver::StepEnabling(Time now, TxBatch& out) {
  if (config_.mode_codes.Meaning(state_.control_mode) == ControlMode::kCan) {
    Enter(DriverPhase::kReady, now);
  } else if (now - phase_start_ > config_.enable_timeout) {
    Fail(Status::kTimeout, Problem::kNotEnabled, state_.control_mode);
  } else if (now >= next_request_) {
    Send(Encode(can::kBaseModeRequest, {.mode = kRequestCan}), out);
    next_request_ = now + config_.request_period;
  }
}

void TracerDriver::StepStopping(Time now, TxBatch& out) {
  const bool at_rest = std::abs(twist_.v_mps) <= config_.standstill_mps &&
                       std::abs(twist_.omega_radps) <= config_.standstill_radps &&
                       twist_stamp_ > phase_start_;
  if (at_rest || now - phase_start_ > config_.stop_timeout) {
    Send(Encode(can::kBaseModeRequest, {.mode = kRequestStandby}), out);
    Enter(DriverPhase::kStopped, now);
  }
}

void TracerDriver::CheckReport() {
  if (phase_ != DriverPhase::kEnabling && phase_ != DriverPhase::kReady) {
    return;
  }
  if (StateOf(state_) == VehicleState::kEmergencyStop) {
    Fail(Status::kFault, Problem::kEmergencyStop, state_.errors);
  } else if (StateOf(state_) == VehicleState::kException) {
    Fail(Status::kFault, Problem::kException, state_.errors);
  } else if ((state_.errors & can::base_error::kUndervoltage) != 0) {
    Fail(Status::kFault, Problem::kUndervoltage, state_.errors);
  } else if (phase_ == DriverPhase::kReady &&
             config_.mode_codes.Meaning(state_.control_mode) != ControlMode::kCan) {
    Fail(Status::kFault, Problem::kControlLost, state_.control_mode);
  }
}

void TracerDriver::CheckAges(Time now) {
  for (const Time stamp : {state_stamp_, twist_stamp_}) {
    const Problem problem = AgeProblem(now, stamp, config_.state_timeout);
    if (problem != Problem::kNone &&
        (phase_ == DriverPhase::kEnabling || phase_ == DriverPhase::kReady)) {
      Fail(Status::kStale, problem, 0);
    }
  }
}

void TracerDriver::SendTwist(Time now, TxBatch& out) {
  // Not due yet; where the clock was set back, it is.
  if (now < next_twist_ && next_twist_ - now <= config_.command_period) {
    return;
  }
  const bool moving = commanded_ && phase_ == DriverPhase::kReady;
  Send(Encode(can::kBaseTwistCommand, moving ? command_ : can::BaseTwistCommand{}), out);
  // Kept to the grid of periods, so that a late cycle does not slow the stream down.
  next_twist_ += config_.command_period;
  if (next_twist_ <= now) {
    next_twist_ = now + config_.command_period;
  }
}

void TracerDriver::Send(const Result<can::Frame>& frame, TxBatch& out) {
  if (!frame.ok() || !out.push_back(*frame)) {
    ++tx_dropped_;
  }
}

void TracerDriver::Stop() {
  stop_requested_ = phase_ != DriverPhase::kStopped && phase_ != DriverPhase::kFault;
}

void TracerDriver::Reset() {
  const can::RxCounters rx = rx_;
  const std::uint64_t late = late_;
  const int tx_dropped = tx_dropped_;
  *this = TracerDriver(config_);
  rx_ = rx;
  late_ = late;
  tx_dropped_ = tx_dropped;
}

void TracerDriver::Enter(DriverPhase phase, Time now) {
  phase_ = phase;
  phase_start_ = now;
}

void TracerDriver::Fail(Status status, Problem problem, std::uint32_t detail) {
  fault_ = {status, problem, 0, detail};
  phase_ = DriverPhase::kFault;
}

bool TracerDriver::emergency_stop() const {
  return StateOf(state_) == VehicleState::kEmergencyStop;
}

}  // namespace pipewright
