// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "ctrl/robot_program/control_task.h"
#include "platform/core/time.h"

namespace pipewright {

enum class ServiceState : std::uint8_t {
  kNoBus,          ///< an interface is missing or down: nothing can be started
  kIdle,           ///< the buses are read, nothing is sent
  kRunning,        ///< the robot program runs, from switching the devices on
  kStopping,       ///< on the way to rest; then the devices are disabled and the threads end
  kEnded,          ///< latched: the run's reason is kept until Rearm
  kEmergencyStop,  ///< latched likewise, and beyond the process: by an operator, or by a run that
                   ///< the process did not survive
  kGone,           ///< asked to end, and the robot is at rest
};

enum class ServiceCommand : std::uint8_t { kStart, kStop, kEmergencyStop, kRearm };

constexpr const char* Name(ServiceState s) {
  switch (s) {
    case ServiceState::kNoBus:
      return "no_bus";
    case ServiceState::kIdle:
      return "idle";
    case ServiceState::kRunning:
      return "running";
    case ServiceState::kStopping:
      return "stopping";
    case ServiceState::kEnded:
      return "ended";
    case ServiceState::kEmergencyStop:
      return "emergency_stop";
    case ServiceState::kGone:
      return "gone";
  }
  return "?";
}

/// What the service knows in one step.
struct ServiceInput {
  bool bus_ok = false;
  bool asked_to_end = false;  ///< SIGTERM; counts once it has been seen
  // of a run, else as they are
  ControlPhase phase = ControlPhase::kStarting;
  bool mission_ended = false;
  std::string_view why;               ///< the mission's end in words
  const char* silent_task = nullptr;  ///< that does not answer
  bool threads_returned = false;
};

/// What is to be done after a step, in this order.
struct ServiceOutput {
  bool start = false;         ///< build the threads; then Started()
  bool request_stop = false;  ///< ask the program to bring the robot to rest and disable it
  bool quit = false;          ///< ask the threads to return
  bool join = false;          ///< they have
};

/// What the service does with the robot: pure, told what happens, no clock and no I/O. No heap.
///
///   no_bus <-> idle --start--> running --> stopping --> ended --rearm--> idle
///   emergency stop from anywhere, through stopping while it runs --> emergency_stop --rearm-->
///   idle asked to end: from anywhere, through stopping while it runs --> gone
class ServiceMachine {
 public:
  static constexpr Duration kStopPatience = std::chrono::seconds(5);   ///< to rest and disabled
  static constexpr Duration kFaultPatience = std::chrono::seconds(1);  ///< quick stop is being sent

  static constexpr Duration kReturnPatience = std::chrono::seconds(30);  ///< with a long plan

  /// @param autostart  starts by itself, once, when it is first idle
  /// @param latched    not empty: begins in kEmergencyStop for this reason
  ServiceMachine(bool autostart, std::string_view latched);

  /// nullptr: it will be done. Else why not, and nothing has changed.
  const char* Command(ServiceCommand command);

  ServiceOutput Step(const ServiceInput& input, Time now);

  /// After `start`. @param error  why the robot could not be started; empty if it was
  void Started(std::string_view error);

  ServiceState state() const { return state_; }
  /// Why it is not running; empty before the first run.
  std::string_view reason() const { return {reason_.data(), reason_size_}; }
  bool latched() const {
    return state_ == ServiceState::kEnded || state_ == ServiceState::kEmergencyStop;
  }
  /// Asked to end, but threads that were asked to return do not: nothing more can be done from
  /// here.
  bool stuck(Time now) const {
    return asked_to_end_ && state_ == ServiceState::kStopping && quit_ &&
           now - quit_at_ > kReturnPatience;
  }

 private:
  void Because(std::string_view reason, std::string_view rest = "");
  bool MustStop(const ServiceInput& input);
  ServiceOutput StepStopping(const ServiceInput& input, Time now);

  ServiceState state_ = ServiceState::kNoBus;
  std::array<char, 200> reason_{};
  std::size_t reason_size_ = 0;
  bool autostart_;
  bool start_asked_ = false;
  bool stop_asked_ = false;
  bool emergency_ = false;
  bool asked_to_end_ = false;
  bool quit_ = false;
  Time stopping_since_{};
  Time quit_at_{};
};

}  // namespace pipewright
