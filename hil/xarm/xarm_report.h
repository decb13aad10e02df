// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "hil/xarm/xarm_protocol.h"

namespace pipewright::hil {

/// Which of its ports a controller reports on.
enum class XarmReportKind : std::uint8_t {
  kReal,      ///< 30003, 100 Hz: status, joint positions
  kRealTime,  ///< 30000, 200 Hz, firmware 2.1.0 and later: a clock, and joint velocities, too
};

constexpr int ReportPort(XarmReportKind kind) {
  return kind == XarmReportKind::kReal ? 30003 : 30000;
}
constexpr Duration ReportPeriod(XarmReportKind kind) {
  return std::chrono::milliseconds(kind == XarmReportKind::kReal ? 10 : 5);
}

/// What a report tells of the arm. Of 30003, no velocity and no time.
struct XarmReport {
  int mode = 0;   ///< xarm_mode
  int state = 0;  ///< xarm_state
  int queued = 0;
  std::uint64_t time_us = 0;
  XarmVector position_rad = XarmVector::Zero();
  XarmVector velocity_radps = XarmVector::Zero();
};

inline constexpr std::size_t kXarmReportBytesMax = 1024;

/// Bytes of the report that begins here, 0 while its length has not come. kMalformed: no report of
/// this kind is that long or that short; what follows on this stream cannot be told apart.
Result<std::size_t> XarmReportBytes(XarmReportKind kind, std::span<const std::uint8_t> bytes);

/// One whole report. Length and integers are big-endian, FP32 little-endian:
///
///            30003    30000
///   length   0 u32    0 u32        (bytes of the whole)
///   time              4 u64        [us]
///   status   4 u8     12 u8        mode << 4 | state
///   queued   5 u16    13 u16
///   position 7        116          7 FP32 [rad], actual
///   velocity          144          7 FP32 [rad/s], actual
///   least    87       784 bytes    (later firmware appends)
///
/// kMalformed: the length; kOutOfRange: a number is not finite or none a joint can have.
/// Source: ufactory_docs, support_articles/developer/firmware/data-description-of-tcp-port.md.
Result<XarmReport> DecodeXarmReport(XarmReportKind kind, std::span<const std::uint8_t> bytes);

/// What the emulated controller sends; fields that XarmReport has not are zero.
/// @returns bytes written
std::size_t EncodeXarmReport(XarmReportKind kind, const XarmReport& report,
                             std::span<std::uint8_t, kXarmReportBytesMax> room);

}  // namespace pipewright::hil
