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

/// The statusword's state bits for `state`; the others are 0. kUnknown gives 0x6F's complement, 0.
constexpr std::uint32_t StatusBits(DriveState state) {
  constexpr std::uint32_t kBits[] = {0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08, 0x00};
  return kBits[static_cast<int>(state)];
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

/// The state that a drive goes to from `from` when it is handed `word`. Automatic transitions
/// (not ready -> disabled, fault reaction -> fault) are the drive's own affair. From operation
/// enabled, shutdown and switch on brake by option code; from quick stop active the drive may be
/// enabled again (605Ah = 5 or 6) or disabled.
///
/// @param reset_edge  bit 7 was low in the controlword before
constexpr DriveState NextState(DriveState from, std::uint32_t word, bool reset_edge) {
  if (from == DriveState::kFault) {
    return (word & 0x80) != 0 && reset_edge ? DriveState::kSwitchOnDisabled : from;
  }
  const bool shutdown = (word & 0x87) == 0x06;
  const bool switch_on = (word & 0x8F) == 0x07;
  const bool enable = (word & 0x8F) == 0x0F;
  const bool no_voltage = (word & 0x82) == 0x00;
  const bool quick_stop = (word & 0x86) == 0x02;
  switch (from) {
    case DriveState::kSwitchOnDisabled:
      return shutdown ? DriveState::kReadyToSwitchOn : from;
    case DriveState::kReadyToSwitchOn:
      if (no_voltage || quick_stop) {
        return DriveState::kSwitchOnDisabled;
      }
      return enable ? DriveState::kOperationEnabled : switch_on ? DriveState::kSwitchedOn : from;
    case DriveState::kSwitchedOn:
      if (no_voltage || quick_stop) {
        return DriveState::kSwitchOnDisabled;
      }
      return shutdown ? DriveState::kReadyToSwitchOn
             : enable ? DriveState::kOperationEnabled
                      : from;
    case DriveState::kOperationEnabled:
      if (no_voltage) {
        return DriveState::kSwitchOnDisabled;
      }
      return quick_stop  ? DriveState::kQuickStopActive
             : shutdown  ? DriveState::kReadyToSwitchOn
             : switch_on ? DriveState::kSwitchedOn
                         : from;
    case DriveState::kQuickStopActive:
      return no_voltage ? DriveState::kSwitchOnDisabled
             : enable   ? DriveState::kOperationEnabled
                        : from;
    case DriveState::kNotReady:
    case DriveState::kFaultReaction:
    case DriveState::kFault:
    case DriveState::kUnknown:
      break;
  }
  return from;
}

}  // namespace pipewright::can
