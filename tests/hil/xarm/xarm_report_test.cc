// SPDX-License-Identifier: MIT
#include "hil/xarm/xarm_report.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace pipewright::hil {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Appends to a report, field by field, in the order of UFACTORY's tables.
struct Table {
  Table& U(std::uint64_t value, int count) {
    for (int i = count - 1; i >= 0; --i) {
      bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    }
    return *this;
  }
  Table& F(const std::vector<float>& values) {
    for (const float value : values) {
      std::uint8_t raw[4];  // this machine's order is the wire's: little-endian
      std::memcpy(raw, &value, 4);
      bytes.insert(bytes.end(), raw, raw + 4);
    }
    return *this;
  }
  Table& Skip(int count) {
    bytes.insert(bytes.end(), static_cast<std::size_t>(count), 0xA5);
    return *this;
  }
  Bytes bytes;
};

const std::vector<float> kPosition = {0.1F, -0.2F, 0.3F, 1.4F, -0.5F, 0.6F, -6.2F};
const std::vector<float> kVelocity = {0.01F, -0.02F, 0.03F, 3.1F, -0.05F, 0.06F, 0};

Table Real(std::uint32_t length = 87) {
  return Table{}.U(length, 4).U(0x41, 1).U(258, 2).F(kPosition).Skip(24).Skip(28);
}

Table RealTime() {
  return Table{}
      .U(784, 4)
      .U(0x0102030405060708, 8)
      .U(0x42, 1)
      .U(3, 2)
      .Skip(17)      // reserved
      .Skip(3 * 28)  // targets
      .F(kPosition)
      .F(kVelocity)
      .Skip(784 - 172);
}

TEST(XarmReport, Of30003IsReadAsTheTableHasIt) {
  const Bytes bytes = Real().bytes;
  ASSERT_EQ(bytes.size(), 87u);
  const Result<XarmReport> report = DecodeXarmReport(XarmReportKind::kReal, bytes);
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->mode, 4);
  EXPECT_EQ(report->state, 1);
  EXPECT_EQ(report->queued, 258);
  for (int i = 0; i < kXarmJoints; ++i) {
    EXPECT_EQ(report->position_rad(i), kPosition[static_cast<std::size_t>(i)]);
  }
}

TEST(XarmReport, Of30000IsReadAsTheTableHasIt) {
  const Bytes bytes = RealTime().bytes;
  ASSERT_EQ(bytes.size(), 784u);
  const Result<XarmReport> report = DecodeXarmReport(XarmReportKind::kRealTime, bytes);
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->time_us, 0x0102030405060708u);
  EXPECT_EQ(report->mode, 4);
  EXPECT_EQ(report->state, 2);
  EXPECT_EQ(report->queued, 3);
  for (int i = 0; i < kXarmJoints; ++i) {
    EXPECT_EQ(report->position_rad(i), kPosition[static_cast<std::size_t>(i)]);
    EXPECT_EQ(report->velocity_radps(i), kVelocity[static_cast<std::size_t>(i)]);
  }
}

TEST(XarmReport, MayHaveBeenLengthenedByLaterFirmware) {
  const Bytes bytes = Real(135).Skip(48).bytes;
  EXPECT_TRUE(DecodeXarmReport(XarmReportKind::kReal, bytes).ok());
}

TEST(XarmReport, OfAWrongLengthIsRefused) {
  for (const std::uint32_t length : {0U, 1U, 86U, 1025U, 0xFFFFFFFFU}) {
    const Bytes bytes = Real(length).bytes;
    EXPECT_EQ(XarmReportBytes(XarmReportKind::kReal, bytes).status(), Status::kMalformed) << length;
    EXPECT_EQ(DecodeXarmReport(XarmReportKind::kReal, bytes).status(), Status::kMalformed);
  }
  const Bytes bytes = Real().bytes;
  for (std::size_t have = 0; have < bytes.size(); ++have) {
    EXPECT_EQ(DecodeXarmReport(XarmReportKind::kReal, std::span(bytes).first(have)).status(),
              Status::kMalformed);
  }
  EXPECT_EQ(XarmReportBytes(XarmReportKind::kRealTime, bytes).status(), Status::kMalformed);
}

TEST(XarmReport, OfWhatNoJointCanHaveIsRefused) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity(), 7.5F, -1e30F}) {
    for (std::size_t joint = 0; joint < kXarmJoints; ++joint) {
      Bytes bytes = Real().bytes;
      std::memcpy(&bytes[7 + 4 * joint], &bad, 4);
      EXPECT_EQ(DecodeXarmReport(XarmReportKind::kReal, bytes).status(), Status::kOutOfRange);
      bytes = RealTime().bytes;
      std::memcpy(&bytes[116 + 4 * joint], &bad, 4);
      EXPECT_EQ(DecodeXarmReport(XarmReportKind::kRealTime, bytes).status(), Status::kOutOfRange);
    }
  }
}

TEST(XarmReport, ThatTheEmulatedControllerWritesIsReadBack) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(-6.3, 6.3);
  for (const XarmReportKind kind : {XarmReportKind::kReal, XarmReportKind::kRealTime}) {
    XarmReport report{.mode = 4, .state = 2, .queued = 7, .time_us = 123456789};
    for (int i = 0; i < kXarmJoints; ++i) {
      report.position_rad(i) = angle(random);
      report.velocity_radps(i) = angle(random) / 3;
    }
    std::array<std::uint8_t, kXarmReportBytesMax> room{};
    const std::size_t size = EncodeXarmReport(kind, report, room);
    const Result<XarmReport> back = DecodeXarmReport(kind, std::span(room).first(size));
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(back->mode, 4);
    EXPECT_EQ(back->state, 2);
    EXPECT_EQ(back->queued, 7);
    EXPECT_TRUE(back->position_rad.isApprox(report.position_rad, 1e-6));
    if (kind == XarmReportKind::kRealTime) {
      EXPECT_EQ(back->time_us, report.time_us);
      EXPECT_TRUE(back->velocity_radps.isApprox(report.velocity_radps, 1e-6));
    }
  }
}

}  // namespace
}  // namespace pipewright::hil
