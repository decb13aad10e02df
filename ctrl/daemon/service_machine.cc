// SPDX-License-Identifier: MIT
#include "ctrl/daemon/service_machine.h"

#include <algorithm>

namespace pipewright {
namespace {

constexpr std::string_view kEmergency = "emergency stop by an operator";

}  // namespace

ServiceMachine::ServiceMachine(bool autostart, std::string_view latched) : autostart_(autostart) {
  if (!latched.empty()) {
    state_ = ServiceState::kEmergencyStop;
    Because(latched);
  }
}

void ServiceMachine::Because(std::string_view reason, std::string_view rest) {
  reason_size_ = 0;
  for (const std::string_view part : {reason, rest}) {
    const std::size_t size = std::min(part.size(), reason_.size() - reason_size_);
    std::copy_n(part.begin(), size, reason_.begin() + static_cast<std::ptrdiff_t>(reason_size_));
    reason_size_ += size;
  }
}

const char* ServiceMachine::Command(ServiceCommand command) {
  switch (command) {
    case ServiceCommand::kStart:
      if (state_ == ServiceState::kNoBus) {
        return "there is no bus to the robot";
      }
      if (latched()) {
        return "latched: re-arm first";
      }
      if (state_ != ServiceState::kIdle || start_asked_) {
        return "it runs already";
      }
      start_asked_ = true;
      return nullptr;
    case ServiceCommand::kStop:
      if (start_asked_) {
        start_asked_ = false;
        return nullptr;
      }
      if (state_ != ServiceState::kRunning) {
        return "it does not run";
      }
      stop_asked_ = true;
      return nullptr;
    case ServiceCommand::kEmergencyStop:
      emergency_ = true;
      start_asked_ = false;
      return nullptr;
    case ServiceCommand::kRearm:
      if (!latched() || emergency_) {
        return "nothing is latched";
      }
      state_ = ServiceState::kNoBus;  // idle with the next step, if there is a bus
      reason_size_ = 0;
      autostart_ = false;  // whoever re-arms says when
      return nullptr;
  }
  return "?";
}

/// Whether a running robot is to be brought to rest; notes why.
bool ServiceMachine::MustStop(const ServiceInput& input) {
  if (emergency_) {
    Because(kEmergency);
  } else if (input.silent_task != nullptr) {
    Because(input.silent_task, " does not answer");
  } else if (asked_to_end_) {
    Because("the service was asked to end");
  } else if (stop_asked_) {
    Because("stopped by an operator");
  } else if (input.mission_ended) {
    Because(input.why);
  } else {
    return false;
  }
  return true;
}

ServiceOutput ServiceMachine::Step(const ServiceInput& input, Time now) {
  ServiceOutput out;
  asked_to_end_ = asked_to_end_ || input.asked_to_end;
  switch (state_) {
    case ServiceState::kNoBus:
    case ServiceState::kIdle:
    case ServiceState::kEnded:
    case ServiceState::kEmergencyStop:
      if (emergency_) {
        emergency_ = false;
        state_ = ServiceState::kEmergencyStop;
        Because(kEmergency);
      }
      break;
    case ServiceState::kRunning:
      if (MustStop(input)) {
        state_ = ServiceState::kStopping;
        stopping_since_ = now;
        quit_ = false;
        out.request_stop = true;
      }
      return out;
    case ServiceState::kStopping:
      return StepStopping(input, now);
    case ServiceState::kGone:
      return out;
  }
  if (asked_to_end_) {
    state_ = ServiceState::kGone;
    return out;
  }
  if (latched()) {
    return out;
  }
  state_ = input.bus_ok ? ServiceState::kIdle : ServiceState::kNoBus;
  start_asked_ = start_asked_ && input.bus_ok;
  if (state_ == ServiceState::kIdle && (start_asked_ || autostart_)) {
    start_asked_ = autostart_ = false;
    stop_asked_ = false;
    state_ = ServiceState::kRunning;
    out.start = true;
  }
  return out;
}

ServiceOutput ServiceMachine::StepStopping(const ServiceInput& input, Time now) {
  ServiceOutput out;
  if (emergency_ && !quit_) {
    Because(kEmergency);
  }
  const Duration patience = input.phase == ControlPhase::kFault ? kFaultPatience : kStopPatience;
  const bool late = now - stopping_since_ > patience;
  if (!quit_ && (input.phase == ControlPhase::kStopped || late)) {
    quit_ = true;
    quit_at_ = now;
    out.quit = true;
    if (input.phase != ControlPhase::kStopped && input.phase != ControlPhase::kFault) {
      Because(reason(), "; it was not seen to come to rest");
    }
  }
  if (quit_ && input.threads_returned) {
    out.join = true;
    state_ = emergency_ ? ServiceState::kEmergencyStop : ServiceState::kEnded;
    emergency_ = false;
  }
  return out;
}

void ServiceMachine::Started(std::string_view error) {
  if (!error.empty()) {
    Because(error);
    state_ = ServiceState::kEnded;
  }
}

}  // namespace pipewright
