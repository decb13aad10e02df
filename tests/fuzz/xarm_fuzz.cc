// SPDX-License-Identifier: MIT
// UFACTORY's wire: any bytes as requests, answers and reports. The first byte chooses the stream.
#include <cmath>
#include <cstring>

#include "hil/xarm/xarm_report.h"
#include "tests/fuzz/require.h"

namespace pipewright::test {
namespace {

using hil::XarmFrame;
using Bytes = std::span<const std::uint8_t>;

void TryFrame(Bytes bytes) {
  const Result<XarmFrame> frame = hil::DecodeXarmFrame(bytes);
  Require(frame.ok(), "what is told apart is a frame");
  std::array<std::uint8_t, XarmFrame::kBytesMax> room{};
  const std::size_t size = hil::EncodeXarmFrame(*frame, room);
  Require(size == bytes.size() && std::memcmp(room.data(), bytes.data(), size) == 0,
          "it is written as it was read");
  Require(frame->size <= XarmFrame::kPayloadMax, "a payload has an end");
  if (const auto velocity = hil::DecodeXarmVelocity(*frame); velocity.ok()) {
    Require(velocity->velocity_radps.allFinite() && std::isfinite(velocity->duration_s),
            "velocities are numbers");
    const Result<XarmFrame> again = hil::XarmVelocityRequest(*velocity);
    Require(!again.ok() || velocity->duration_s > 0, "none without an end is sent");
    Require(!again.ok() || velocity->velocity_radps.cwiseAbs().maxCoeff() <= 3.1416,
            "none is faster than a joint");
  }
  if (const auto version = hil::DecodeXarmVersion(*frame); version.ok()) {
    Require(
        version->axes >= 0 && version->major >= 0 && version->minor >= 0 && version->revision >= 0,
        "versions are counts");
  }
  (void)hil::DecodeXarmErrors(*frame);
}

void ReadFrames(Bytes bytes) {
  while (true) {
    const Result<std::size_t> size = hil::XarmFrameBytes(bytes);
    if (!size.ok() || *size == 0 || *size > bytes.size()) {
      Require(!size.ok() || *size <= XarmFrame::kBytesMax, "it fits where it is read into");
      return;
    }
    TryFrame(bytes.first(*size));
    bytes = bytes.subspan(*size);
  }
}

void ReadReports(hil::XarmReportKind kind, Bytes bytes) {
  while (true) {
    const Result<std::size_t> size = hil::XarmReportBytes(kind, bytes);
    if (!size.ok() || *size == 0 || *size > bytes.size()) {
      Require(!size.ok() || *size <= hil::kXarmReportBytesMax, "it fits where it is read into");
      return;
    }
    if (const auto report = hil::DecodeXarmReport(kind, bytes.first(*size)); report.ok()) {
      Require((report->position_rad.array().abs() <= 7).all() &&
                  (report->velocity_radps.array().abs() <= 10).all(),
              "a report is of what an arm can do");
      Require(report->mode >= 0 && report->mode < 16 && report->state >= 0 && report->state < 16,
              "mode and state are half a byte");
      std::array<std::uint8_t, hil::kXarmReportBytesMax> room{};
      const std::size_t written = hil::EncodeXarmReport(kind, *report, room);
      const auto again = hil::DecodeXarmReport(kind, Bytes(room).first(written));
      Require(again.ok() && again->position_rad == report->position_rad &&
                  again->velocity_radps == report->velocity_radps &&
                  again->time_us == report->time_us && again->mode == report->mode &&
                  again->state == report->state && again->queued == report->queued,
              "what is read is written as it was");
    }
    bytes = bytes.subspan(*size);
  }
}

}  // namespace
}  // namespace pipewright::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace pipewright;
  if (size == 0) {
    return 0;
  }
  const std::span<const std::uint8_t> rest(bytes + 1, size - 1);
  switch (bytes[0] % 3) {
    case 0:
      test::ReadFrames(rest);
      break;
    case 1:
      test::ReadReports(hil::XarmReportKind::kReal, rest);
      break;
    default:
      test::ReadReports(hil::XarmReportKind::kRealTime, rest);
      break;
  }
  return 0;
}
