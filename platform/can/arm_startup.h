// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "platform/can/cia402.h"
#include "platform/can/cia402_state.h"
#include "platform/can/sdo.h"

/// What the host asks and writes at each drive before it starts it: the wire's contract, on which
/// driver and emulated drive agree. The order of a remapping (parameter off, count 0, entries,
/// count, parameter on) is CiA 301's, 7.5.2.36.
namespace pipewright::can {

/// The drives must fault when the host's heartbeat stays away this long.
inline constexpr int kHostHeartbeatTimeout_ms = 300;
/// The same for RPDO1, the joint's command.
inline constexpr int kCommandTimeout_ms = 100;
inline constexpr int kHeartbeatPeriod_ms = 100;
inline constexpr int kArmCycle_ms = 10;

enum class StepKind : std::uint32_t {
  kExpect,      ///< read; the answer must be `value`
  kExpectBits,  ///< read; the answer must hold the bits of `value`
  kWrite,
};

struct StartupStep {
  StepKind kind;
  Object object;
  int bytes;  ///< written; of a read: 0
  std::uint32_t value;
  bool add_node = false;  ///< the node id is added to `value`

  constexpr std::uint32_t ValueFor(int node) const {
    return add_node ? value + static_cast<std::uint32_t>(node) : value;
  }
};

/// A PDO mapping entry: index << 16 | subindex << 8 | bits.
constexpr std::uint32_t MappingEntry(Object object, std::uint32_t bits) {
  return object.index << 16 | object.subindex << 8 | bits;
}

inline constexpr std::uint32_t kPdoOff = 1U << 31;  ///< in a PDO's COB-ID: not valid
inline constexpr std::uint32_t kSynchronous = 1;    ///< transmission type: at every SYNC
inline constexpr std::uint32_t kOnChange = 255;     ///< transmission type: on change, and by timer

// clang-format off
inline constexpr StartupStep kArmStartup[] = {
    {StepKind::kExpectBits, object::kSupportedModes,         0, kSupportsCyclicVelocity},
    {StepKind::kExpect,     object::kPositionUnit,           0, kUnitMicroRad},
    {StepKind::kExpect,     object::kVelocityUnit,           0, kUnitMicroRadPerSecond},
    // RPDO1: controlword and target velocity, taken over at SYNC
    {StepKind::kWrite,      {0x1400, 1},                     4, kPdoOff | kJointCommand.head.id, true},
    {StepKind::kWrite,      {0x1400, 2},                     1, kSynchronous},
    {StepKind::kWrite,      {0x1600, 0},                     1, 0},
    {StepKind::kWrite,      {0x1600, 1},                     4, MappingEntry(object::kControlword, 16)},
    {StepKind::kWrite,      {0x1600, 2},                     4, MappingEntry(object::kTargetVelocity, 32)},
    {StepKind::kWrite,      {0x1600, 0},                     1, 2},
    {StepKind::kWrite,      {0x1400, 5},                     2, kCommandTimeout_ms},
    {StepKind::kWrite,      {0x1400, 1},                     4, kJointCommand.head.id, true},
    // TPDO1: position and velocity, sampled at SYNC
    {StepKind::kWrite,      {0x1800, 1},                     4, kPdoOff | kJointFeedback.head.id, true},
    {StepKind::kWrite,      {0x1800, 2},                     1, kSynchronous},
    {StepKind::kWrite,      {0x1A00, 0},                     1, 0},
    {StepKind::kWrite,      {0x1A00, 1},                     4, MappingEntry(object::kPosition, 32)},
    {StepKind::kWrite,      {0x1A00, 2},                     4, MappingEntry(object::kVelocity, 32)},
    {StepKind::kWrite,      {0x1A00, 0},                     1, 2},
    {StepKind::kWrite,      {0x1800, 1},                     4, kJointFeedback.head.id, true},
    // TPDO2: statusword and mode, on change, at most every 10 ms, at least every 250 ms
    {StepKind::kWrite,      {0x1801, 1},                     4, kPdoOff | kJointStatus.head.id, true},
    {StepKind::kWrite,      {0x1801, 2},                     1, kOnChange},
    {StepKind::kWrite,      {0x1801, 3},                     2, 100},
    {StepKind::kWrite,      {0x1801, 5},                     2, 250},
    {StepKind::kWrite,      {0x1A01, 0},                     1, 0},
    {StepKind::kWrite,      {0x1A01, 1},                     4, MappingEntry(object::kStatusword, 16)},
    {StepKind::kWrite,      {0x1A01, 2},                     4, MappingEntry(object::kModeDisplay, 8)},
    {StepKind::kWrite,      {0x1A01, 0},                     1, 2},
    {StepKind::kWrite,      {0x1801, 1},                     4, kJointStatus.head.id, true},
    // each side watches the other's heartbeat
    {StepKind::kWrite,      object::kProducerHeartbeat,      2, kHeartbeatPeriod_ms},
    {StepKind::kWrite,      object::kConsumerHeartbeat1,     4, kHostNode << 16 | kHostHeartbeatTimeout_ms},
    // cyclic synchronous velocity, one set point every 10 · 10^-3 s
    {StepKind::kWrite,      object::kMode,                   1, kModeCyclicVelocity},
    {StepKind::kWrite,      object::kInterpolationValue,     1, kArmCycle_ms},
    {StepKind::kWrite,      object::kInterpolationExponent,  1, 0xFD},
};
// clang-format on

}  // namespace pipewright::can
