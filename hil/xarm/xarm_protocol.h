// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "platform/core/frames.h"
#include "platform/core/status.h"
#include "platform/core/time.h"

/// The private protocol of UFACTORY's controllers, on TCP port 502.
///
///   request   | transaction u16 | protocol u16 = 2 | length u16 | register u8 | parameters |
///   response  | transaction u16 | protocol u16 = 2 | length u16 | register u8 | state u8, values |
///
/// `length` counts what follows it. Header integers are big-endian, FP32 little-endian.
/// Source: xArm-Developer/ufactory_docs, communication_protocol/: p05 (frames, state byte),
/// p07, p08 and p14 (registers); xArm-Python-SDK, xarm/core/wrapper/uxbus_cmd_tcp.py (state bit 3).
namespace pipewright::hil {

inline constexpr int kXarmJoints = 7;
using XarmVector = Vec<kXarmJoints>;
inline constexpr double kXarmSpeedLimit_radps = 3.14159265358979;  ///< 180 deg/s

enum class XarmRegister : std::uint8_t {
  kVersion = 1,
  kMotionEnable = 11,
  kSetState = 12,
  kGetState = 13,
  kQueuedCommands = 14,
  kGetError = 15,
  kCleanError = 16,
  kCleanWarning = 17,
  kSetMode = 19,
  kJointPositions = 42,
  kJointVelocity = 81,
};

/// Register 19, and the high half of a report's status byte.
namespace xarm_mode {
inline constexpr int kPosition = 0;
inline constexpr int kTeach = 2;
inline constexpr int kJointVelocity = 4;
}  // namespace xarm_mode

/// Register 13, and the low half of a report's status byte. Register 12 takes kReady and kStopped.
namespace xarm_state {
inline constexpr int kReady = 0;
inline constexpr int kMoving = 1;
inline constexpr int kSleeping = 2;  ///< ready, and at rest
inline constexpr int kPaused = 3;
inline constexpr int kStopped = 4;
inline constexpr int kReset = 5;
/// Whether a motion command is taken in that state.
constexpr bool Moves(int state) { return state >= kReady && state <= kSleeping; }
}  // namespace xarm_state

/// Bits of a response's state byte.
namespace xarm_status {
inline constexpr std::uint8_t kInvalid = 0x08;
inline constexpr std::uint8_t kCannotMove = 0x10;
inline constexpr std::uint8_t kWarning = 0x20;
inline constexpr std::uint8_t kError = 0x40;
}  // namespace xarm_status

/// One request or response. Of a response the first payload byte is the state.
struct XarmFrame {
  static constexpr std::size_t kHeaderBytes = 6;
  static constexpr std::size_t kPayloadMax = 250;
  static constexpr std::size_t kBytesMax = kHeaderBytes + 1 + kPayloadMax;
  static constexpr std::uint16_t kPrivateProtocol = 2;

  std::uint16_t transaction = 0;
  std::uint16_t protocol = kPrivateProtocol;
  std::uint8_t register_number = 0;
  std::array<std::uint8_t, kPayloadMax> data{};
  std::size_t size = 0;  ///< of data

  XarmRegister reg() const { return static_cast<XarmRegister>(register_number); }
  std::span<const std::uint8_t> payload() const { return {data.data(), size}; }
};

/// Bytes of the frame that begins here, 0 while its length has not come. kMalformed: no frame is
/// that long or that short; what follows on this stream cannot be told apart.
Result<std::size_t> XarmFrameBytes(std::span<const std::uint8_t> bytes);
/// `bytes` is one whole frame, else kMalformed. Any protocol.
Result<XarmFrame> DecodeXarmFrame(std::span<const std::uint8_t> bytes);
/// @returns bytes written
std::size_t EncodeXarmFrame(const XarmFrame& frame,
                            std::span<std::uint8_t, XarmFrame::kBytesMax> room);

/// A request of no parameters.
XarmFrame XarmAsk(XarmRegister reg);
XarmFrame XarmMotionEnable(bool enable);  ///< all joints
XarmFrame XarmSetState(int state);
XarmFrame XarmSetMode(int mode);

/// Register 81: joint velocities, which the controller itself ends after `duration`.
struct XarmVelocity {
  XarmVector velocity_radps = XarmVector::Zero();
  bool together = true;   ///< joints accelerate and decelerate synchronously
  double duration_s = 0;  ///< 0 and less: never
};
/// kOutOfRange: a velocity is not finite or beyond kXarmSpeedLimit_radps, or a duration is not in
/// (0, 1] s. There is no request without an end.
Result<XarmFrame> XarmVelocityRequest(const XarmVelocity& velocity);
/// What a controller reads; the duration may be missing. kMalformed, or kOutOfRange: not finite.
Result<XarmVelocity> DecodeXarmVelocity(const XarmFrame& request);

/// The answer to a request; `values` follow the state byte.
XarmFrame XarmResponse(const XarmFrame& request, std::uint8_t state,
                       std::span<const std::uint8_t> values = {});

/// Register 15's answer.
struct XarmErrors {
  int error = 0;
  int warning = 0;
};
Result<XarmErrors> DecodeXarmErrors(const XarmFrame& response);

/// Register 1's answer, "7,7,XI1303,AC1303,v2.5.0": axes, type, arm, control box, firmware.
struct XarmVersion {
  int axes = 0;
  int major = 0;
  int minor = 0;
  int revision = 0;

  bool AtLeast(int a, int b, int c) const {
    return major != a ? major > a : minor != b ? minor > b : revision >= c;
  }
};
Result<XarmVersion> DecodeXarmVersion(const XarmFrame& response);

}  // namespace pipewright::hil
