// SPDX-License-Identifier: MIT
#pragma once

#include "platform/can/cia402_messages.h"
#include "platform/can/table.h"

/// The arm on CAN: one CiA 402 drive per joint, node id = joint number (1 to 7), low byte first,
/// cyclic synchronous velocity mode. UFACTORY publishes no CAN interface for this arm: carrying it
/// as seven CiA 402 nodes is this project's own adaptation, after CiA 301 and CiA 402-2.
namespace pipewright::can {

inline constexpr int kArmNodes = 7;
inline constexpr int kHostNode = 0x7F;  ///< its heartbeat is what the drives watch
inline constexpr int kArmBitrate = 1'000'000;
inline constexpr double kRadPerUnit = 1e-6;  ///< positions in 1e-6 rad, velocities in 1e-6 rad/s
inline constexpr double kJointSpeedLimit_radps = 3.141592;  ///< 180 deg/s, in whole user units

namespace cia402_internal {
using std::chrono_literals::operator""ms;
inline constexpr auto kLittle = ByteOrder::kLittleEndian;
inline constexpr auto kTo = Direction::kToDevice;
inline constexpr auto kFrom = Direction::kFromDevice;
inline constexpr auto kS = Sign::kSigned;
inline constexpr auto kU = Sign::kUnsigned;
inline constexpr int kLast = kArmNodes;
inline constexpr double kUnit = kRadPerUnit;
inline constexpr double kMin32 = -2147.483648;
inline constexpr double kMax32 = 2147.483647;
inline constexpr double kSpeed = kJointSpeedLimit_radps;
// clang-format off

inline constexpr FrameSpec<Nmt, 2> kNmtRow{
  {"nmt", 0x000, 0, 2, 2, {}, kLittle, kTo}, {{
  //  name             unit     field                                  start bits sign scale           min          max
    {"command",         "1",     kField<&Nmt::command>,                    0,  8, kU, 1.0,               0,          255},
    {"node",            "1",     kField<&Nmt::node>,                       8,  8, kU, 1.0,               0,          127},
}}};

inline constexpr FrameSpec<Sync, 0> kSyncRow{
  {"sync", 0x080, 0, 0, 1, 10ms, kLittle, kTo}, {}};

inline constexpr FrameSpec<Emergency, 3> kEmergencyRow{
  {"emergency", 0x080, kLast, 8, 8, {}, kLittle, kFrom}, {{
    {"code",            "1",     kField<&Emergency::code>,                 0, 16, kU, 1.0,               0,        65535},
    {"error_register",  "1",     kField<&Emergency::error_register>,      16,  8, kU, 1.0,               0,          255},
    {"vendor",          "1",     kField<&Emergency::vendor>,              24, 32, kU, 1.0,               0,   0x1p32 - 1},
}}};

inline constexpr FrameSpec<JointFeedback, 2> kFeedbackRow{
  {"tpdo1_joint_feedback", 0x180, kLast, 8, 8, 10ms, kLittle, kFrom}, {{
    {"position",        "rad",   kField<&JointFeedback::position_rad>,     0, 32, kS, kUnit,        kMin32,       kMax32},
    {"velocity",        "rad/s", kField<&JointFeedback::velocity_radps>,  32, 32, kS, kUnit,        kMin32,       kMax32},
}}};

inline constexpr FrameSpec<JointCommand, 2> kCommandRow{
  {"rpdo1_joint_command", 0x200, kLast, 6, 6, 10ms, kLittle, kTo}, {{
    {"controlword",     "1",     kField<&JointCommand::controlword>,       0, 16, kU, 1.0,               0,        65535},
    {"velocity",        "rad/s", kField<&JointCommand::velocity_radps>,   16, 32, kS, kUnit,       -kSpeed,       kSpeed},
}}};

inline constexpr FrameSpec<JointStatus, 2> kStatusRow{
  {"tpdo2_joint_status", 0x280, kLast, 3, 3, 250ms, kLittle, kFrom}, {{
    {"statusword",      "1",     kField<&JointStatus::statusword>,         0, 16, kU, 1.0,               0,        65535},
    {"mode",            "1",     kField<&JointStatus::mode>,              16,  8, kU, 1.0,               0,          255},
}}};

constexpr FrameSpec<Sdo, 4> SdoRow(const FrameHead& head) {
  return {head, {{
    {"command",         "1",     kField<&Sdo::command>,                    0,  8, kU, 1.0,               0,          255},
    {"index",           "1",     kField<&Sdo::index>,                      8, 16, kU, 1.0,               0,        65535},
    {"subindex",        "1",     kField<&Sdo::subindex>,                  24,  8, kU, 1.0,               0,          255},
    {"data",            "1",     kField<&Sdo::data>,                      32, 32, kU, 1.0,               0,   0x1p32 - 1},
  }}};
}

inline constexpr FrameSpec<Heartbeat, 1> kHeartbeatRow{
  {"heartbeat", 0x700, 127, 1, 1, 100ms, kLittle, kFrom}, {{
    {"state",           "1",     kField<&Heartbeat::state>,                0,  8, kU, 1.0,               0,          127},
}}};

// clang-format on
}  // namespace cia402_internal

inline constexpr auto kNmt = cia402_internal::kNmtRow;
inline constexpr auto kSync = cia402_internal::kSyncRow;
inline constexpr auto kEmergency = cia402_internal::kEmergencyRow;
inline constexpr auto kJointFeedback = cia402_internal::kFeedbackRow;
inline constexpr auto kJointCommand = cia402_internal::kCommandRow;
inline constexpr auto kJointStatus = cia402_internal::kStatusRow;
inline constexpr auto kSdoResponse = cia402_internal::SdoRow(
    {"sdo_response", 0x580, kArmNodes, 8, 8, {}, ByteOrder::kLittleEndian, Direction::kFromDevice});
inline constexpr auto kSdoRequest = cia402_internal::SdoRow(
    {"sdo_request", 0x600, kArmNodes, 8, 8, {}, ByteOrder::kLittleEndian, Direction::kToDevice});
inline constexpr auto kHeartbeat = cia402_internal::kHeartbeatRow;

/// The whole bus of the arm. Driver, emulated drives, docs and tests iterate over this.
inline constexpr std::tuple kArmTable{kNmt,           kSync,         kEmergency,
                                      kJointFeedback, kJointCommand, kJointStatus,
                                      kSdoResponse,   kSdoRequest,   kHeartbeat};
static_assert(WellFormed(kArmTable));

}  // namespace pipewright::can
