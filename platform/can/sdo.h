// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "platform/can/cia402_messages.h"

/// Expedited SDO transfers (CiA 301, 7.2.4.3): one request, one answer, up to four bytes.
namespace pipewright::can {

/// An entry of a device's object dictionary.
struct Object {
  std::uint32_t index = 0;
  std::uint32_t subindex = 0;

  friend constexpr bool operator==(const Object&, const Object&) = default;
};

/// Objects of CiA 301 and CiA 402 that this bus uses.
namespace object {
inline constexpr Object kDeviceType{0x1000, 0};
inline constexpr Object kErrorRegister{0x1001, 0};
inline constexpr Object kConsumerHeartbeat1{0x1016, 1};  ///< node << 16 | timeout in ms
inline constexpr Object kProducerHeartbeat{0x1017, 0};   ///< ms
inline constexpr Object kVendorId{0x1018, 1};
inline constexpr Object kControlword{0x6040, 0};
inline constexpr Object kStatusword{0x6041, 0};
inline constexpr Object kMode{0x6060, 0};
inline constexpr Object kModeDisplay{0x6061, 0};
inline constexpr Object kPosition{0x6064, 0};
inline constexpr Object kVelocity{0x606C, 0};
inline constexpr Object kInterpolationValue{0x60C2, 1};  ///< cycle = value · 10^exponent s
inline constexpr Object kInterpolationExponent{0x60C2, 2};
inline constexpr Object kTargetVelocity{0x60FF, 0};
inline constexpr Object kPositionUnit{0x60A8, 0};
inline constexpr Object kVelocityUnit{0x60A9, 0};
inline constexpr Object kSupportedModes{0x6502, 0};  ///< bit 8: cyclic synchronous velocity
}  // namespace object

inline constexpr std::uint32_t kSupportsCyclicVelocity = 1U << 8;
/// SI unit codes (CiA 303-2): prefix micro, numerator rad, denominator 1 or s.
inline constexpr std::uint32_t kUnitMicroRad = 0xFA100000;
inline constexpr std::uint32_t kUnitMicroRadPerSecond = 0xFA100300;

/// Abort codes (CiA 301, table 22).
enum class SdoAbort : std::uint32_t {
  kNone = 0,
  kTimeout = 0x05040000,
  kUnknownCommand = 0x05040001,
  kWriteOnly = 0x06010001,
  kReadOnly = 0x06010002,
  kNoSuchObject = 0x06020000,
  kNotMappable = 0x06040041,
  kMappingTooLong = 0x06040042,
  kWrongLength = 0x06070010,
  kNoSuchSubindex = 0x06090011,
  kValueRange = 0x06090030,
  kGeneral = 0x08000000,
  kWrongState = 0x08000022,
};

/// Reads `object`.
constexpr Sdo UploadRequest(Object object) { return {0x40, object.index, object.subindex, 0}; }

/// Writes the low `bytes` (1 to 4) bytes of `value`.
constexpr Sdo DownloadRequest(Object object, int bytes, std::uint32_t value) {
  const auto unused = static_cast<std::uint32_t>(4 - bytes);
  return {0x23 | (unused << 2), object.index, object.subindex, value};
}

constexpr Sdo UploadResponse(Object object, int bytes, std::uint32_t value) {
  const auto unused = static_cast<std::uint32_t>(4 - bytes);
  return {0x43 | (unused << 2), object.index, object.subindex, value};
}

constexpr Sdo DownloadResponse(Object object) { return {0x60, object.index, object.subindex, 0}; }

constexpr Sdo Abort(Object object, SdoAbort why) {
  return {0x80, object.index, object.subindex, static_cast<std::uint32_t>(why)};
}

enum class SdoKind : std::uint8_t {
  kUploadRequest,
  kDownloadRequest,
  kUploadResponse,
  kDownloadResponse,
  kAbort,
  kOther,  ///< segmented or block transfer, or no command at all: not spoken here
};

/// What an SDO says. The two directions share command bytes, so say which one it came from.
struct SdoMeaning {
  SdoKind kind = SdoKind::kOther;
  Object object;
  int bytes = 0;            ///< of value; 4 when the sender gave no size
  std::uint32_t value = 0;  ///< data cut to `bytes`, or the abort code
};

constexpr SdoMeaning Meaning(const Sdo& sdo, bool from_server) {
  SdoMeaning meaning{SdoKind::kOther, {sdo.index, sdo.subindex}, 0, 0};
  const std::uint32_t kind = sdo.command & 0xE0;
  const bool expedited = (sdo.command & 0x02) != 0;
  const bool sized = (sdo.command & 0x01) != 0;
  const std::uint32_t unused = sized ? (sdo.command >> 2) & 3 : 0;
  if (kind == 0x80) {
    meaning.kind = SdoKind::kAbort;
    meaning.bytes = 4;
  } else if (kind == 0x40 && !from_server) {
    meaning.kind = SdoKind::kUploadRequest;
  } else if (kind == 0x60 && from_server) {
    meaning.kind = SdoKind::kDownloadResponse;
  } else if (expedited && kind == (from_server ? 0x40 : 0x20)) {
    meaning.kind = from_server ? SdoKind::kUploadResponse : SdoKind::kDownloadRequest;
    meaning.bytes = 4 - static_cast<int>(unused);
  }
  meaning.value = meaning.bytes == 4 ? sdo.data : sdo.data & ((1U << (8 * meaning.bytes)) - 1);
  return meaning;
}

}  // namespace pipewright::can
