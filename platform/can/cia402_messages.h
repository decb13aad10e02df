// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

/// What the frames of the arm's seven CiA 402 drives say; cia402.h has their rows.
namespace pipewright::can {

struct Nmt {
  std::uint32_t command = 0;  ///< NmtCommand
  std::uint32_t node = 0;     ///< 0: all
};

/// No payload is used; a counter byte, if there is one, is ignored.
struct Sync {};

struct Emergency {
  std::uint32_t code = 0;            ///< 0: no error any more
  std::uint32_t error_register = 0;  ///< object 1001h
  std::uint32_t vendor = 0;
};

/// Sampled at SYNC.
struct JointFeedback {
  double position_rad = 0;    ///< 6064h
  double velocity_radps = 0;  ///< 606Ch
};

/// Takes effect at the next SYNC.
struct JointCommand {
  std::uint32_t controlword = 0;  ///< 6040h
  double velocity_radps = 0;      ///< 60FFh
};

struct JointStatus {
  std::uint32_t statusword = 0;  ///< 6041h
  std::uint32_t mode = 0;        ///< 6061h; 9: cyclic synchronous velocity
};

/// Expedited SDO; sdo.h builds and reads it.
struct Sdo {
  std::uint32_t command = 0;
  std::uint32_t index = 0;
  std::uint32_t subindex = 0;
  std::uint32_t data = 0;
};

struct Heartbeat {
  std::uint32_t state = 0;  ///< NmtState
};

enum class NmtCommand : std::uint8_t {
  kStart = 0x01,
  kStop = 0x02,
  kPreOperational = 0x80,
  kResetNode = 0x81,
  kResetCommunication = 0x82,
};

enum class NmtState : std::uint8_t {
  kBootUp = 0x00,
  kStopped = 0x04,
  kOperational = 0x05,
  kPreOperational = 0x7F,
};

/// Emergency codes (CiA 301, CiA 402) that this bus uses.
namespace emergency {
inline constexpr std::uint32_t kNone = 0x0000;
inline constexpr std::uint32_t kFollowingError = 0x8611;
inline constexpr std::uint32_t kHeartbeatLost = 0x8130;
inline constexpr std::uint32_t kPdoLost = 0x8250;
}  // namespace emergency

}  // namespace pipewright::can
