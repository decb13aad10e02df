// SPDX-License-Identifier: MIT
#include "hil/xarm/xarm_gateway.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

namespace pipewright::hil {
namespace {

constexpr double kUnlimited_radps2 = 3900;  ///< from rest to full speed in one step of 1 ms

}  // namespace

const char* Name(XarmPhase phase) {
  switch (phase) {
    case XarmPhase::kConnecting:
      return "connecting";
    case XarmPhase::kAsking:
      return "asking";
    case XarmPhase::kIdle:
      return "idle";
    case XarmPhase::kEnabling:
      return "enabling";
    case XarmPhase::kOperating:
      return "operating";
    case XarmPhase::kDoubting:
      return "doubting";
    case XarmPhase::kStopping:
      return "stopping";
    case XarmPhase::kFaulted:
      return "fault";
    case XarmPhase::kRefused:
      return "refused";
  }
  return "?";
}

bool XarmGatewayConfig::Valid() const {
  return (lower_rad.array() < upper_rad.array()).all() && (lower_rad.array() > -7).all() &&
         (upper_rad.array() < 7).all() && brake_radps2 > 0 && brake_radps2 <= 20 &&
         least_gap > Duration::zero() && resend >= least_gap && velocity_duration >= 2 * resend &&
         velocity_duration <= std::chrono::seconds(1) &&
         report_timeout >= 2 * ReportPeriod(controller.report) &&
         enable_timeout > Duration::zero() && rest_timeout > Duration::zero() &&
         retry > Duration::zero() && poll > Duration::zero() && rest_radps > 0;
}

XarmGateway::XarmGateway(const XarmGatewayConfig& config, Port& bus)
    : config_(config), bus_(bus), client_(config.controller) {
  assert(config.Valid());
  nodes_.reserve(kXarmJoints);
  for (int i = 0; i < kXarmJoints; ++i) {
    nodes_.emplace_back(Cia402Config{.node_id = i + 1,
                                     .lower_rad = config.lower_rad(i),
                                     .upper_rad = config.upper_rad(i),
                                     .accel_radps2 = kUnlimited_radps2,
                                     .quick_stop_radps2 = config.brake_radps2,
                                     .host_may_loosen = false});
  }
}

void XarmGateway::Step(Time now) {
  client_.Step(now);
  ReadController(now);
  ReadBus(now);
  StepPhase(now);
  StepNodes(now);
  SendVelocities(now);
}

void XarmGateway::Enter(XarmPhase phase, Time now) {
  phase_ = phase;
  since_ = now;
  confirming_ = -1;
  for (Cia402Node& node : nodes_) {
    node.PermitOperation(phase == XarmPhase::kOperating);
  }
}

bool XarmGateway::AtWork() const {
  return phase_ == XarmPhase::kEnabling || phase_ == XarmPhase::kOperating ||
         phase_ == XarmPhase::kDoubting || phase_ == XarmPhase::kStopping;
}

bool XarmGateway::AnyWaits() const {
  return std::any_of(nodes_.begin(), nodes_.end(), [](const Cia402Node& n) { return n.waits(); });
}

/// A drive that is enabled, or still braking.
bool XarmGateway::AnyAtWork() const {
  return std::any_of(nodes_.begin(), nodes_.end(), [](const Cia402Node& n) {
    return n.drive_state() == DriveState::kOperationEnabled || n.velocity_radps() != 0;
  });
}

void XarmGateway::Connect(Time now) {
  ++counters_.connections;
  samples_.clear();
  velocity_radps_.reset();
  fit_ = false;
  cleaned_ = false;
  asked_all_ = false;
  trying_ = true;
  client_.Connect(now);
  Enter(XarmPhase::kConnecting, now);
}

void XarmGateway::Ask(const XarmFrame& request, Time now) {
  const Status status = client_.Ask(request, now);
  if (status != Status::kOk) {
    LoseLink(status == Status::kFull ? XarmProblem::kNoAnswer : XarmProblem::kClosed, now);
  }
}

// ---- what goes wrong

void XarmGateway::RaiseOnAll(std::uint16_t emcy, std::uint32_t vendor) {
  held_ = true;
  ++counters_.faults;
  for (Cia402Node& node : nodes_) {
    node.RaiseInternalFault(emcy, vendor);
  }
}

void XarmGateway::Fault(std::uint16_t emcy, std::uint32_t vendor, const std::string& why,
                        Time now) {
  trouble_ = why;
  reset_asked_ = false;
  RaiseOnAll(emcy, vendor);
  Enter(XarmPhase::kFaulted, now);
}

void XarmGateway::FaultByErrors(const XarmErrors& errors, Time now) {
  Fault(xarm_emergency::kControllerError,
        static_cast<std::uint32_t>(errors.error | errors.warning << 8),
        fmt::format("the controller has error {}", errors.error), now);
}

/// It may still hear; and if not, its own watchdog ends the motion.
void XarmGateway::AskForRest(Time now) {
  const Result<XarmFrame> rest =
      XarmVelocityRequest({.duration_s = ToSeconds(config_.velocity_duration)});
  if (rest.ok()) {
    (void)client_.Ask(*rest, now);
  }
}

void XarmGateway::Stop(Time now) {
  if (!AtWork()) {
    return;
  }
  AskForRest(now);
  (void)client_.Ask(XarmSetState(xarm_state::kStopped), now);
  Fault(xarm_emergency::kLinkLost, 0, "the gateway was ended", now);
}

void XarmGateway::LoseLink(XarmProblem problem, Time now) {
  const auto vendor = static_cast<std::uint32_t>(problem);
  const std::string why = fmt::format("link lost: {}", Name(problem));
  if (AtWork()) {
    AskForRest(now);
    return Fault(xarm_emergency::kLinkLost, vendor, why, now);
  }
  trouble_ = why;
  if (report_ && !held_) {
    RaiseOnAll(xarm_emergency::kLinkLost, vendor);
  }
  client_.Close();
  reset_asked_ = false;  // it was about what was known then
  trying_ = false;
  next_try_ = now + config_.retry;
  Enter(XarmPhase::kConnecting, now);
}

void XarmGateway::Refuse(const std::string& why) {
  trouble_ = why;
  client_.Close();
  phase_ = XarmPhase::kRefused;
}

// ---- each step

void XarmGateway::ReadBus(Time now) {
  can::Frame frame;
  while (bus_.Receive(frame)) {
    synced_ = synced_ || (!frame.error && !frame.extended && frame.id == can::kSync.head.id);
    for (Cia402Node& node : nodes_) {
      node.OnFrame(frame, now);
    }
  }
}

void XarmGateway::StepPhase(Time now) {
  switch (phase_) {
    case XarmPhase::kConnecting:
      return StepConnecting(now);
    case XarmPhase::kIdle:
      return StepIdle(now);
    case XarmPhase::kEnabling:
      return StepEnabling(now);
    case XarmPhase::kOperating:
      if (!AnyAtWork() && !AnyWaits()) {
        stop_sent_ = false;
        Enter(XarmPhase::kStopping, now);
      }
      return;
    case XarmPhase::kStopping:
      return StepStopping(now);
    case XarmPhase::kFaulted:
      if (std::any_of(nodes_.begin(), nodes_.end(),
                      [](const auto& n) { return n.reset_asked(); })) {
        reset_asked_ = true;
        Connect(now);
      }
      return;
    case XarmPhase::kAsking:    // OnAnswer, OnReport
    case XarmPhase::kDoubting:  // OnAnswer
    case XarmPhase::kRefused:
      return;
  }
}

void XarmGateway::StepConnecting(Time now) {
  if (!trying_ && now >= next_try_) {
    Connect(now);
  } else if (trying_ && client_.problem() != XarmProblem::kNone) {
    LoseLink(client_.problem(), now);
  } else if (trying_ && client_.up()) {
    trying_ = false;
    heard_ = now;
    Enter(XarmPhase::kAsking, now);
    Ask(XarmAsk(XarmRegister::kVersion), now);
  }
}

void XarmGateway::StepIdle(Time now) {
  if (AnyWaits()) {
    Enter(XarmPhase::kEnabling, now);
    Ask(XarmAsk(XarmRegister::kGetError), now);
  } else if (now - last_poll_ >= config_.poll) {
    last_poll_ = now;
    Ask(XarmAsk(XarmRegister::kGetState), now);
  }
}

void XarmGateway::StepEnabling(Time now) {
  if (!AnyWaits()) {  // the host thought better of it
    stop_sent_ = false;
    Enter(XarmPhase::kStopping, now);
  } else if (now - since_ > config_.enable_timeout) {
    Fault(xarm_emergency::kRefused, 0,
          fmt::format("the controller was enabled, but stays in mode {}, state {}", report_->mode,
                      report_->state),
          now);
  }
}

void XarmGateway::StepStopping(Time now) {
  const bool rests = velocity_radps_ && velocity_radps_->cwiseAbs().maxCoeff() < config_.rest_radps;
  if (!stop_sent_ && (rests || now - since_ > config_.rest_timeout)) {
    stop_sent_ = true;
    Ask(XarmSetState(xarm_state::kStopped), now);
  }
}

void XarmGateway::StepNodes(Time now) {
  for (Cia402Node& node : nodes_) {
    node.Step(now, outbox_);
  }
  for (const can::Frame& frame : outbox_) {
    counters_.send_failures += bus_.Send(frame) == Status::kOk ? 0 : 1;
  }
  outbox_.clear();
}

void XarmGateway::SendVelocities(Time now) {
  const bool sends =
      phase_ == XarmPhase::kOperating || (phase_ == XarmPhase::kStopping && !stop_sent_);
  const Duration since = now - last_velocity_;
  if (!sends || since < (synced_ ? config_.least_gap : config_.resend)) {
    return;
  }
  XarmVelocity velocity{.duration_s = ToSeconds(config_.velocity_duration)};
  for (int i = 0; i < kXarmJoints; ++i) {
    velocity.velocity_radps(i) = std::clamp(nodes_[static_cast<std::size_t>(i)].velocity_radps(),
                                            -kXarmSpeedLimit_radps, kXarmSpeedLimit_radps);
  }
  const Result<XarmFrame> request = XarmVelocityRequest(velocity);
  if (!request.ok()) {
    return;  // nothing that is not a number leaves; the last request ends by itself
  }
  synced_ = false;
  last_velocity_ = now;
  ++counters_.velocities;
  Ask(*request, now);
}

}  // namespace pipewright::hil
