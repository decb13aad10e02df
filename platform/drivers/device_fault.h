// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string_view>

#include "platform/can/frame.h"
#include "platform/core/fixed_vector.h"
#include "platform/core/status.h"
#include "platform/core/time.h"

namespace pipewright {

/// What one Step of a driver sends, in order.
using TxBatch = FixedVector<can::Frame, 32>;

enum class DriverPhase : std::uint8_t {
  kWaiting,      ///< for the device to be heard
  kConfiguring,  ///< writing its parameters
  kEnabling,     ///< asking it to take commands
  kReady,        ///< it follows commands
  kStopping,     ///< at rest soon, then disabled
  kStopped,      ///< asked to stop, and did
  kFault,        ///< see fault(); latched until Reset()
};

/// What is wrong with a device.
enum class Problem : std::uint8_t {
  kNone,
  kNotHeard,         ///< nothing came from the device after start
  kSetupUnanswered,  ///< an SDO request was not answered; detail: object index
  kSetupRefused,     ///< an SDO request was aborted; detail: abort code
  kWrongDevice,      ///< a setup answer is not what this driver is for; detail: object index
  kNotEnabled,       ///< it answers but does not take commands; detail: mode or statusword
  kStateStale,       ///< its state or feedback frames stay away
  kStateAhead,       ///< they are stamped in the future: how old they are, nobody knows
  kHeartbeatLost,
  kRebooted,     ///< a boot-up message while it should have been at work
  kControlLost,  ///< it left the mode in which it takes our commands; detail: mode or statusword
  kEmergencyStop,
  kException,  ///< the base's own exception state; detail: error bits
  kUndervoltage,
  kDriveFault,        ///< a drive's fault state; detail: its last emergency code
  kEmergencyMessage,  ///< detail: emergency code
  kBusOff,            ///< the host's CAN controller left the bus; detail: error class bits
};

constexpr std::string_view Name(Problem problem) {
  switch (problem) {
    case Problem::kNone:
      return "nothing";
    case Problem::kNotHeard:
      return "not heard on the bus";
    case Problem::kSetupUnanswered:
      return "does not answer its set-up";
    case Problem::kSetupRefused:
      return "refuses its set-up";
    case Problem::kWrongDevice:
      return "is not the device expected";
    case Problem::kNotEnabled:
      return "does not accept control";
    case Problem::kStateStale:
      return "no longer reports its state";
    case Problem::kStateAhead:
      return "reports a state of the future";
    case Problem::kHeartbeatLost:
      return "lost its heartbeat";
    case Problem::kRebooted:
      return "restarted";
    case Problem::kControlLost:
      return "left control by CAN";
    case Problem::kEmergencyStop:
      return "emergency stop";
    case Problem::kException:
      return "reports an exception";
    case Problem::kUndervoltage:
      return "battery under-voltage";
    case Problem::kDriveFault:
      return "drive fault";
    case Problem::kEmergencyMessage:
      return "sent an emergency message";
    case Problem::kBusOff:
      return "bus off";
  }
  return "?";
}

/// Whether a frame stamped at `stamp` tells of `now`: younger than `timeout`, and no more ahead.
constexpr Problem AgeProblem(Time now, Time stamp, Duration timeout) {
  const Duration age = now - stamp;
  return age > timeout    ? Problem::kStateStale
         : age < -timeout ? Problem::kStateAhead
                          : Problem::kNone;
}

struct DeviceFault {
  Status status = Status::kOk;
  Problem problem = Problem::kNone;
  int node = 0;              ///< the drive, 1 to 7; 0: the device as a whole
  std::uint32_t detail = 0;  ///< by problem
};

}  // namespace pipewright
