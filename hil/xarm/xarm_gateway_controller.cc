// SPDX-License-Identifier: MIT
// What the gateway hears from the controller, and what it concludes.
#include <fmt/format.h>

#include <algorithm>

#include "hil/xarm/xarm_gateway.h"

namespace pipewright::hil {
namespace {

constexpr int kConfirming =
    2;  ///< reports that must say so: the first may be older than the answer

/// Empty: fit.
std::string WhyUnfit(const XarmVersion& version, XarmReportKind report) {
  const std::string firmware =
      fmt::format("firmware {}.{}.{}", version.major, version.minor, version.revision);
  if (version.axes != kXarmJoints) {
    return fmt::format("the arm has {} axes, not {}", version.axes, kXarmJoints);
  }
  if (!version.AtLeast(1, 8, 0)) {
    return firmware + " does not end a velocity by itself; 1.8.0 and later do";
  }
  if (report == XarmReportKind::kRealTime && !version.AtLeast(2, 1, 0)) {
    return firmware + " has no report port 30000; 2.1.0 and later have, or take 30003";
  }
  return "";
}

bool Follows(const XarmReport& report) {
  return report.mode == xarm_mode::kJointVelocity && xarm_state::Moves(report.state);
}

}  // namespace

void XarmGateway::ReadController(Time now) {
  XarmReport report;
  while (client_.TakeReport(report)) {
    OnReport(report, now);
  }
  XarmFrame answer;
  while (client_.TakeAnswer(answer)) {
    OnAnswer(answer, now);
  }
  if (phase_ != XarmPhase::kAsking && phase_ != XarmPhase::kIdle && !AtWork()) {
    return;
  }
  const Duration patience =
      phase_ == XarmPhase::kAsking ? config_.controller.connect_timeout : config_.report_timeout;
  if (client_.problem() != XarmProblem::kNone) {
    LoseLink(client_.problem(), now);
  } else if (now - heard_ > patience) {
    LoseLink(XarmProblem::kSilent, now);
  }
}

void XarmGateway::OnReport(const XarmReport& report, Time now) {
  if (phase_ != XarmPhase::kAsking && counters_.reports > 0) {
    counters_.silence_max = std::max(counters_.silence_max, now - heard_);
  }
  ++counters_.reports;
  heard_ = now;
  Measure(report, now);
  const bool measured = phase_ == XarmPhase::kAsking && asked_all_;
  // Somebody has it; no node is enabled, and nothing more is ours to say.
  const bool taken = phase_ == XarmPhase::kStopping && !stop_sent_ && !Follows(report);
  if (measured || taken) {
    BeIdle(now);
  } else if (phase_ == XarmPhase::kOperating && !Follows(report)) {
    Doubt(now);
  } else if (confirming_ >= 0) {
    ++confirming_;
    Confirm(report, now);
  }
}

/// Reports since an answer that they are to confirm.
void XarmGateway::Confirm(const XarmReport& report, Time now) {
  const bool enough = confirming_ >= kConfirming;
  if (phase_ == XarmPhase::kEnabling && enough && Follows(report)) {
    Enter(XarmPhase::kOperating, now);
  } else if (phase_ == XarmPhase::kDoubting && (enough || !Follows(report))) {
    Fault(xarm_emergency::kTakenOver, static_cast<std::uint32_t>(report.state | report.mode << 8),
          fmt::format("somebody else has taken the arm: mode {}, state {}", report.mode,
                      report.state),
          now);
  }
}

void XarmGateway::Measure(const XarmReport& report, Time now) {
  if (!fit_) {
    return;  // whose joints these are is not known yet
  }
  report_ = report;
  if (samples_.full()) {
    std::copy(samples_.begin() + 1, samples_.end(), samples_.begin());
    samples_.pop_back();
  }
  (void)samples_.push_back({now, report.position_rad});
  const double window_s = ToSeconds(now - samples_[0].at);
  if (config_.controller.report == XarmReportKind::kRealTime) {
    velocity_radps_ = report.velocity_radps;
  } else if (window_s > 0) {
    velocity_radps_ = (report.position_rad - samples_[0].position_rad) / window_s;
  }
  for (int i = 0; i < kXarmJoints; ++i) {
    const double velocity = velocity_radps_ ? (*velocity_radps_)(i) : 0;
    nodes_[static_cast<std::size_t>(i)].Measure(report.position_rad(i), velocity);
  }
}

void XarmGateway::BeIdle(Time now) {
  if (held_) {
    held_ = false;
    for (Cia402Node& node : nodes_) {
      node.ClearInternalFault();
    }
  }
  reset_asked_ = false;
  trouble_.clear();
  last_poll_ = now;
  Enter(XarmPhase::kIdle, now);
}

/// Something stopped the arm. Its own errors tell whether that was the controller or a person.
void XarmGateway::Doubt(Time now) {
  Enter(XarmPhase::kDoubting, now);
  Ask(XarmAsk(XarmRegister::kGetError), now);
}

void XarmGateway::OnAnswer(const XarmFrame& answer, Time now) {
  switch (phase_) {
    case XarmPhase::kAsking:
      return OnAnswerAsking(answer, now);
    case XarmPhase::kEnabling:
      return OnAnswerEnabling(answer, now);
    case XarmPhase::kOperating:
    case XarmPhase::kDoubting:
    case XarmPhase::kStopping:
      return OnAnswerAtWork(answer, now);
    case XarmPhase::kConnecting:
    case XarmPhase::kIdle:
    case XarmPhase::kFaulted:
    case XarmPhase::kRefused:
      return;
  }
}

void XarmGateway::OnVersion(const XarmFrame& answer, Time now) {
  const Result<XarmVersion> version = DecodeXarmVersion(answer);
  if (!version.ok()) {
    return Refuse("the controller's version cannot be read");
  }
  version_ = *version;
  if (const std::string why = WhyUnfit(*version, config_.controller.report); !why.empty()) {
    return Refuse(why);
  }
  fit_ = true;
  Ask(XarmAsk(XarmRegister::kGetError), now);
}

void XarmGateway::OnAnswerAsking(const XarmFrame& answer, Time now) {
  switch (answer.reg()) {
    case XarmRegister::kVersion:
      return OnVersion(answer, now);
    case XarmRegister::kCleanError:
      return Ask(XarmAsk(XarmRegister::kCleanWarning), now);
    case XarmRegister::kCleanWarning:
      return Ask(XarmAsk(XarmRegister::kGetError), now);
    case XarmRegister::kGetError:
      break;
    default:
      return;
  }
  const Result<XarmErrors> errors = DecodeXarmErrors(answer);
  if (!errors.ok()) {
    LoseLink(XarmProblem::kMalformed, now);
  } else if (errors->error == 0) {
    asked_all_ = true;  // now where its joints stand
  } else if (reset_asked_ && !cleaned_) {
    cleaned_ = true;
    Ask(XarmAsk(XarmRegister::kCleanError), now);
  } else {
    FaultByErrors(*errors, now);
  }
}

void XarmGateway::OnAnswerEnabling(const XarmFrame& answer, Time now) {
  const std::uint8_t state = answer.data[0];
  const auto reg = static_cast<std::uint32_t>(answer.register_number);
  if ((state & xarm_status::kInvalid) != 0) {
    return Fault(xarm_emergency::kRefused, reg | static_cast<std::uint32_t>(state) << 8,
                 fmt::format("the controller refused register {}", reg), now);
  }
  switch (answer.reg()) {
    case XarmRegister::kGetError: {
      const Result<XarmErrors> errors = DecodeXarmErrors(answer);
      if (!errors.ok()) {
        return LoseLink(XarmProblem::kMalformed, now);
      }
      return errors->error != 0 ? FaultByErrors(*errors, now) : Ask(XarmMotionEnable(true), now);
    }
    // Enabling and changing mode both take the controller's state back; so it is set last.
    case XarmRegister::kMotionEnable:
      return Ask(XarmSetMode(xarm_mode::kJointVelocity), now);
    case XarmRegister::kSetMode:
      return Ask(XarmSetState(xarm_state::kReady), now);
    case XarmRegister::kSetState:
      confirming_ = 0;
      return (state & xarm_status::kError) != 0 ? Doubt(now) : void();
    default:
      return;
  }
}

void XarmGateway::OnAnswerAtWork(const XarmFrame& answer, Time now) {
  const std::uint8_t state = answer.data[0];
  const bool stopped = (state & (xarm_status::kError | xarm_status::kCannotMove)) != 0;
  if (answer.reg() == XarmRegister::kJointVelocity && phase_ == XarmPhase::kOperating) {
    if ((state & xarm_status::kInvalid) != 0) {
      return Fault(xarm_emergency::kRefused,
                   static_cast<std::uint32_t>(answer.register_number | state << 8),
                   "the controller refused a velocity", now);
    }
    return stopped ? Doubt(now) : void();
  }
  if (answer.reg() == XarmRegister::kSetState && phase_ == XarmPhase::kStopping && stop_sent_ &&
      client_.unanswered() == 0) {
    return BeIdle(now);
  }
  if (answer.reg() != XarmRegister::kGetError || phase_ != XarmPhase::kDoubting) {
    return;
  }
  const Result<XarmErrors> errors = DecodeXarmErrors(answer);
  if (!errors.ok()) {
    return LoseLink(XarmProblem::kMalformed, now);
  }
  if (errors->error != 0) {
    return FaultByErrors(*errors, now);
  }
  confirming_ = 0;  // what it was stopped by, a report tells
}

}  // namespace pipewright::hil
