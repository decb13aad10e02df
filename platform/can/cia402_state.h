// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

/// The CiA 402 state machine as pure functions, for the driver and for the emulated drive.
namespace pipewright::can {

/// CiA 402 states, as a statusword (6041h) tells them.
enum class DriveState : std::uint8_t {
  kNotReady,
  kSwitchOnDisabled,
  kReadyToSwitchOn,
  kSwitchedOn,
  kOperationEnabled,
  kQuickStopActive,
  kFaultReaction,
  kFault,
  kUnknown,  ///< no state has this pattern
};

/// CiA 402-2, table of statusword patterns: (mask, value) per state.
constexpr DriveState StateOf(std::uint32_t statusword) {
  switch (statusword & 0x4F) {
    case 0x00:
      return DriveState::kNotReady;
    case 0x40:
      return DriveState::kSwitchOnDisabled;
    case 0x0F:
      return DriveState::kFaultReaction;
    case 0x08:
      return DriveState::kFault;
    default:
      break;
  }
  switch (statusword & 0x6F) {
    case 0x21:
      return DriveState::kReadyToSwitchOn;
    case 0x23:
      return DriveState::kSwitchedOn;
    case 0x27:
      return DriveState::kOperationEnabled;
    case 0x07:
      return DriveState::kQuickStopActive;
    default:
      return DriveState::kUnknown;
  }
}

constexpr const char* Name(DriveState state) {
  constexpr const char* kNames[] = {
      "not ready",         "switch on disabled", "ready to switch on", "switched on",
      "operation enabled", "quick stop active",  "fault reaction",     "fault",
      "unknown",
  };
  return kNames[static_cast<int>(state)];
}

/// Statusword bits beside the state.
namespace statusword {
inline constexpr std::uint32_t kVoltage = 1U << 4;
inline constexpr std::uint32_t kWarning = 1U << 7;
inline constexpr std::uint32_t kRemote = 1U << 9;
inline constexpr std::uint32_t kInternalLimit = 1U << 11;
inline constexpr std::uint32_t kFollowsCommand = 1U << 12;  ///< in CSV: the drive follows 60FFh
}  // namespace statusword

/// Controlword values (6040h).
namespace controlword {
inline constexpr std::uint32_t kDisableVoltage = 0x00;
inline constexpr std::uint32_t kQuickStop = 0x02;
inline constexpr std::uint32_t kShutdown = 0x06;
inline constexpr std::uint32_t kSwitchOn = 0x07;
inline constexpr std::uint32_t kEnableOperation = 0x0F;
inline constexpr std::uint32_t kFaultReset = 0x80;  ///< acts on its rising edge
}  // namespace controlword

inline constexpr std::uint32_t kModeCyclicVelocity = 9;

/// The controlword that takes a drive one state nearer to operation enabled. A fault reset needs a
/// rising edge: pass the controlword sent before.
constexpr std::uint32_t EnableWord(DriveState state, std::uint32_t sent_before) {
  switch (state) {
    case DriveState::kSwitchOnDisabled:
      return controlword::kShutdown;
    case DriveState::kReadyToSwitchOn:
      return controlword::kSwitchOn;
    case DriveState::kSwitchedOn:
    case DriveState::kOperationEnabled:
      return controlword::kEnableOperation;
    case DriveState::kFault:
      return (sent_before & controlword::kFaultReset) != 0 ? controlword::kDisableVoltage
                                                           : controlword::kFaultReset;
    case DriveState::kNotReady:
    case DriveState::kQuickStopActive:
    case DriveState::kFaultReaction:
    case DriveState::kUnknown:
      break;
  }
  return controlword::kDisableVoltage;
}

}  // namespace pipewright::can
