// SPDX-License-Identifier: MIT
#include "hil/xarm/xarm_report.h"

#include <algorithm>

#include "hil/xarm/wire_bytes.h"

namespace pipewright::hil {
namespace {

using namespace wire_bytes;  // NOLINT: one room's names

constexpr double kPositionMax_rad = 7;  ///< no joint turns by more than one revolution either way
constexpr double kVelocityMax_radps = 10;  ///< more than any joint can

/// Where the fields stand; 0: there is none.
struct Layout {
  std::size_t bytes;
  std::size_t time;
  std::size_t status;
  std::size_t position;
  std::size_t velocity;
};

constexpr Layout LayoutOf(XarmReportKind kind) {
  return kind == XarmReportKind::kReal ? Layout{87, 0, 4, 7, 0} : Layout{784, 4, 12, 116, 144};
}

XarmVector Joints(Bytes bytes, std::size_t at) {
  XarmVector joints;
  for (std::size_t i = 0; i < kXarmJoints; ++i) {
    joints(static_cast<Eigen::Index>(i)) = Float(bytes, at + 4 * i);
  }
  return joints;
}

void PutJoints(Room room, std::size_t at, const XarmVector& joints) {
  for (std::size_t i = 0; i < kXarmJoints; ++i) {
    PutFloat(room, at + 4 * i, joints(static_cast<Eigen::Index>(i)));
  }
}

/// Not so of a number that is none.
bool Within(const XarmVector& joints, double limit) {
  return (joints.array().abs() <= limit).all();
}

}  // namespace

Result<std::size_t> XarmReportBytes(XarmReportKind kind, Bytes bytes) {
  if (bytes.size() < 4) {
    return std::size_t{0};
  }
  const std::size_t length = Integer(bytes, 0, 4);
  if (length < LayoutOf(kind).bytes || length > kXarmReportBytesMax) {
    return Status::kMalformed;
  }
  return length;
}

Result<XarmReport> DecodeXarmReport(XarmReportKind kind, Bytes bytes) {
  const Result<std::size_t> length = XarmReportBytes(kind, bytes);
  if (!length.ok() || *length == 0 || *length != bytes.size()) {
    return Status::kMalformed;
  }
  const Layout at = LayoutOf(kind);
  XarmReport report;
  report.mode = bytes[at.status] >> 4;
  report.state = bytes[at.status] & 0x0F;
  report.queued = static_cast<int>(Integer(bytes, at.status + 1, 2));
  report.position_rad = Joints(bytes, at.position);
  if (at.velocity > 0) {
    report.time_us = Integer(bytes, at.time, 8);
    report.velocity_radps = Joints(bytes, at.velocity);
  }
  if (!Within(report.position_rad, kPositionMax_rad) ||
      !Within(report.velocity_radps, kVelocityMax_radps)) {
    return Status::kOutOfRange;
  }
  return report;
}

std::size_t EncodeXarmReport(XarmReportKind kind, const XarmReport& report,
                             std::span<std::uint8_t, kXarmReportBytesMax> room) {
  const Layout at = LayoutOf(kind);
  std::fill_n(room.begin(), at.bytes, std::uint8_t{0});
  PutInteger(room, 0, 4, at.bytes);
  room[at.status] = static_cast<std::uint8_t>(report.mode << 4 | (report.state & 0x0F));
  PutInteger(room, at.status + 1, 2, static_cast<std::uint64_t>(report.queued));
  PutJoints(room, at.position, report.position_rad);
  if (at.velocity > 0) {
    PutInteger(room, at.time, 8, report.time_us);
    PutJoints(room, at.velocity, report.velocity_radps);
  }
  return at.bytes;
}

}  // namespace pipewright::hil
