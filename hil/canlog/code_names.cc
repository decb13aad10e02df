// SPDX-License-Identifier: MIT
#include "hil/canlog/code_names.h"

#include <iterator>
#include <span>

#include "platform/can/cia402_messages.h"
#include "platform/can/cia402_state.h"
#include "platform/can/sdo.h"

namespace pipewright::hil {
namespace {

using Buffer = fmt::memory_buffer;

struct Named {
  std::uint32_t code;
  std::string_view name;
};

template <typename Code>
constexpr std::uint32_t U(Code code) {
  return static_cast<std::uint32_t>(code);
}

// clang-format off
constexpr Named kVehicleStates[] = {
    {U(can::VehicleState::kNormal), "normal"},
    {U(can::VehicleState::kEmergencyStop), "emergency stop"},
    {U(can::VehicleState::kException), "exception"},
};
constexpr Named kBaseErrors[] = {
    {can::base_error::kDriverAbnormal, "motor driver abnormal"},
    {can::base_error::kUndervoltage, "undervoltage"},
    {can::base_error::kUndervoltageWarning, "undervoltage warning"},
    {can::base_error::kRemoteLost, "remote control lost"},
    {can::base_error::kMotor1Lost, "motor 1 lost"},
    {can::base_error::kMotor2Lost, "motor 2 lost"},
    {can::base_error::kEmergencyStop, "emergency stop"},
};
constexpr Named kDriverBits[] = {
    {1U << 2, "over-current"}, {1U << 4, "CAN lost"}, {1U << 6, "enabled"},
};
constexpr Named kOnOff[] = {{0, "off"}, {1, "on"}};
constexpr Named kLightModes[] = {{0, "off"}, {1, "on"}, {2, "breathing"}, {3, "custom"}};
constexpr Named kSwitches[] = {{1, "middle"}, {2, "up"}, {3, "down"}};
constexpr Named kModeRequests[] = {{0, "standby"}, {1, "CAN"}, {2, "serial"}};
constexpr Named kErrorResets[] = {{0, "all"}, {1, "motor 1"}, {2, "motor 2"}};
constexpr Named kNmtCommands[] = {
    {U(can::NmtCommand::kStart), "start"},
    {U(can::NmtCommand::kStop), "stop"},
    {U(can::NmtCommand::kPreOperational), "enter pre-operational"},
    {U(can::NmtCommand::kResetNode), "reset node"},
    {U(can::NmtCommand::kResetCommunication), "reset communication"},
};
constexpr Named kNmtStates[] = {
    {U(can::NmtState::kBootUp), "boot-up"},
    {U(can::NmtState::kStopped), "stopped"},
    {U(can::NmtState::kOperational), "operational"},
    {U(can::NmtState::kPreOperational), "pre-operational"},
};
/// Beside those of this bus, what CiA 301 and CiA 402 drives commonly send.
constexpr Named kEmergencies[] = {
    {can::emergency::kNone, "no error any more"},
    {0x1000, "generic error"},
    {0x2310, "continuous over-current"},
    {0x3210, "overvoltage"},
    {0x3220, "undervoltage"},
    {0x4210, "device too hot"},
    {0x4310, "drive too hot"},
    {0x7300, "sensor"},
    {0x8110, "CAN overrun"},
    {0x8120, "CAN error passive"},
    {can::emergency::kHeartbeatLost, "heartbeat lost"},
    {0x8140, "recovered from bus off"},
    {0x8210, "PDO too short"},
    {can::emergency::kPdoLost, "PDO lost"},
    {can::emergency::kFollowingError, "following error"},
};
constexpr Named kErrorRegister[] = {  // object 1001h
    {1U << 0, "generic"},        {1U << 1, "current"}, {1U << 2, "voltage"},
    {1U << 3, "temperature"},    {1U << 4, "communication"}, {1U << 5, "device profile"},
    {1U << 7, "manufacturer"},
};
constexpr Named kControlwords[] = {
    {can::controlword::kDisableVoltage, "disable voltage"},
    {can::controlword::kQuickStop, "quick stop"},
    {can::controlword::kShutdown, "shutdown"},
    {can::controlword::kSwitchOn, "switch on"},
    {can::controlword::kEnableOperation, "enable operation"},
    {can::controlword::kFaultReset, "fault reset"},
};
constexpr Named kStatusBits[] = {
    {can::statusword::kVoltage, "voltage"},
    {can::statusword::kWarning, "warning"},
    {can::statusword::kRemote, "remote"},
    {can::statusword::kInternalLimit, "internal limit"},
    {can::statusword::kFollowsCommand, "follows command"},
};
constexpr Named kDriveModes[] = {  // 6061h
    {0, "none"}, {1, "profile position"}, {3, "profile velocity"}, {4, "profile torque"},
    {6, "homing"}, {7, "interpolated position"}, {8, "cyclic synchronous position"},
    {can::kModeCyclicVelocity, "cyclic synchronous velocity"}, {10, "cyclic synchronous torque"},
};
// clang-format on

void AppendHex(Buffer& to, std::uint32_t code, int digits) {
  fmt::format_to(std::back_inserter(to), "0x{:0{}X}", code, digits);
}

void AppendNumber(Buffer& to, std::uint32_t code, const ControlModes&) {
  fmt::format_to(std::back_inserter(to), "{}", code);
}

std::string_view Find(std::span<const Named> names, std::uint32_t code) {
  for (const Named& named : names) {
    if (named.code == code) {
      return named.name;
    }
  }
  return {};
}

template <const auto& kNames>
void AppendOneOf(Buffer& to, std::uint32_t code, const ControlModes& modes) {
  const std::string_view name = Find(kNames, code);
  if (name.empty()) {
    AppendNumber(to, code, modes);
  } else {
    AppendText(to, name);
  }
}

/// The names of the bits that are set; bits without a name as one number.
void AppendBits(Buffer& to, std::uint32_t code, std::span<const Named> names,
                std::string_view none) {
  const std::size_t begin = to.size();
  for (const Named& named : names) {
    if ((code & named.code) != 0) {
      AppendText(to, to.size() > begin ? ", " : "");
      AppendText(to, named.name);
      code &= ~named.code;
    }
  }
  if (code != 0) {
    AppendText(to, to.size() > begin ? ", " : "");
    AppendHex(to, code, 1);
  } else if (to.size() == begin) {
    AppendText(to, none);
  }
}

template <const auto& kNames>
void AppendAllOf(Buffer& to, std::uint32_t code, const ControlModes&) {
  AppendBits(to, code, kNames, "none");
}

void AppendControlMode(Buffer& to, std::uint32_t code, const ControlModes& modes) {
  constexpr std::string_view kNames[] = {"standby", "CAN", "serial", "remote control"};
  const can::ControlMode mode = modes.Meaning(code);
  if (mode == can::ControlMode::kUnknown) {
    AppendNumber(to, code, modes);
  } else {
    AppendText(to, kNames[static_cast<int>(mode)]);
  }
}

void AppendNode(Buffer& to, std::uint32_t code, const ControlModes& modes) {
  if (code == 0) {
    AppendText(to, "all");
  } else {
    AppendNumber(to, code, modes);
  }
}

void AppendControlword(Buffer& to, std::uint32_t code, const ControlModes&) {
  const std::string_view name = Find(kControlwords, code);
  if (name.empty()) {
    AppendHex(to, code, 4);
  } else {
    AppendText(to, name);
  }
}

/// The state, then the other bits that have a name.
void AppendStatusword(Buffer& to, std::uint32_t code, const ControlModes&) {
  AppendText(to, can::Name(can::StateOf(code)));
  for (const Named& bit : kStatusBits) {
    if ((code & bit.code) != 0) {
      AppendText(to, ", ");
      AppendText(to, bit.name);
    }
  }
}

template <bool kFromServer>
void AppendSdoKind(Buffer& to, std::uint32_t code, const ControlModes& modes) {
  switch (can::Meaning({.command = code}, kFromServer).kind) {
    case can::SdoKind::kUploadRequest:
      return AppendText(to, "read");
    case can::SdoKind::kDownloadRequest:
      return AppendText(to, "write");
    case can::SdoKind::kUploadResponse:
      return AppendText(to, "value");
    case can::SdoKind::kDownloadResponse:
      return AppendText(to, "written");
    case can::SdoKind::kAbort:
      return AppendText(to, "abort");
    case can::SdoKind::kOther:
      return AppendNumber(to, code, modes);
  }
}

void AppendIndex(Buffer& to, std::uint32_t code, const ControlModes&) {
  fmt::format_to(std::back_inserter(to), "{:04X}h", code);
}

void AppendEmergencyName(Buffer& to, std::uint32_t code, const ControlModes&) {
  const std::string_view name = Find(kEmergencies, code);
  if (name.empty()) {
    AppendHex(to, code, 4);
  } else {
    AppendText(to, name);
  }
}

/// How the codes of a signal get their names. Of its two tables at most one is not empty; both are
/// when each code of a byte is asked for its name.
struct SignalNames {
  std::string_view frame;
  std::string_view signal;
  AppendCode append;
  std::span<const Named> codes = {};
  std::span<const Named> bits = {};
  bool each_of_a_byte = false;
};

template <const auto& kNames>
constexpr SignalNames OneOf(std::string_view frame, std::string_view signal) {
  return {frame, signal, AppendOneOf<kNames>, kNames};
}
template <const auto& kNames>
constexpr SignalNames AllOf(std::string_view frame, std::string_view signal) {
  return {frame, signal, AppendAllOf<kNames>, {}, kNames};
}
constexpr SignalNames EachOfAByte(std::string_view frame, std::string_view signal,
                                  AppendCode append) {
  return {frame, signal, append, {}, {}, true};
}

constexpr SignalNames kNames[] = {
    OneOf<kVehicleStates>("base_state", "vehicle_state"),
    EachOfAByte("base_state", "control_mode", AppendControlMode),
    AllOf<kBaseErrors>("base_state", "errors"),
    OneOf<kOnOff>("base_light_command", "enabled"),
    OneOf<kLightModes>("base_light_command", "front_mode"),
    OneOf<kLightModes>("base_light_command", "rear_mode"),
    OneOf<kOnOff>("base_light_state", "enabled"),
    OneOf<kLightModes>("base_light_state", "front_mode"),
    OneOf<kLightModes>("base_light_state", "rear_mode"),
    OneOf<kSwitches>("base_remote", "swa"),
    OneOf<kSwitches>("base_remote", "swb"),
    OneOf<kSwitches>("base_remote", "swc"),
    OneOf<kSwitches>("base_remote", "swd"),
    AllOf<kDriverBits>("base_motor_slow", "driver_state"),
    OneOf<kModeRequests>("base_mode_request", "mode"),
    OneOf<kErrorResets>("base_error_reset", "what"),
    OneOf<kNmtCommands>("nmt", "command"),
    EachOfAByte("nmt", "node", AppendNode),
    {"emergency", "code", AppendEmergencyName, kEmergencies},
    AllOf<kErrorRegister>("emergency", "error_register"),
    {"rpdo1_joint_command", "controlword", AppendControlword, kControlwords},
    {"tpdo2_joint_status", "statusword", AppendStatusword, {}, kStatusBits},
    OneOf<kDriveModes>("tpdo2_joint_status", "mode"),
    EachOfAByte("sdo_request", "command", AppendSdoKind<false>),
    {"sdo_request", "index", AppendIndex},
    EachOfAByte("sdo_response", "command", AppendSdoKind<true>),
    {"sdo_response", "index", AppendIndex},
    OneOf<kNmtStates>("heartbeat", "state"),
};

const SignalNames* FindNames(std::string_view frame, std::string_view signal) {
  for (const SignalNames& names : kNames) {
    if (names.frame == frame && names.signal == signal) {
      return &names;
    }
  }
  return nullptr;
}

}  // namespace

AppendCode NamesOf(std::string_view frame, std::string_view signal) {
  const SignalNames* const names = FindNames(frame, signal);
  return names == nullptr ? nullptr : names->append;
}

std::vector<CodeName> NamedCodes(std::string_view frame, std::string_view signal,
                                 const ControlModes& modes) {
  std::vector<CodeName> named;
  const SignalNames* const names = FindNames(frame, signal);
  if (names == nullptr) {
    return named;
  }
  const auto add = [&](std::uint32_t code) {
    Buffer name;
    names->append(name, code, modes);
    if (name[0] < '0' || name[0] > '9') {  // else it has none, and is a number
      named.push_back({code, fmt::to_string(name)});
    }
  };
  for (const Named& one : names->codes) {
    add(one.code);
  }
  for (std::uint32_t code = 0; names->each_of_a_byte && code < 256; ++code) {
    add(code);
  }
  return named;
}

std::vector<CodeName> NamedBits(std::string_view frame, std::string_view signal) {
  std::vector<CodeName> named;
  if (const SignalNames* const names = FindNames(frame, signal)) {
    for (const Named& one : names->bits) {
      named.push_back({one.code, std::string(one.name)});
    }
  }
  return named;
}

void AppendText(Buffer& to, std::string_view text) { to.append(text.begin(), text.end()); }

void AppendEmergency(Buffer& to, std::uint32_t code) {
  const std::string_view name = Find(kEmergencies, code);
  AppendText(to, name.empty() ? "unknown" : name);
  fmt::format_to(std::back_inserter(to), " (0x{:04X})", code);
}

}  // namespace pipewright::hil
