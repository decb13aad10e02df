// SPDX-License-Identifier: MIT
// CAN logs that are text: candump -L by the robot's reader and by the inspector's, which must agree
// line by line; candump and ASC by the inspector's. The input's first byte: odd for times between
// frames.
#include <string_view>

#include "hil/canlog/candump_lines.h"
#include "platform/can/candump.h"
#include "tests/fuzz/read_whole_log.h"

namespace pipewright::test {
namespace {

/// Whether the robot's reader is to take a line that the inspector's takes: it knows no CAN FD, no
/// length code, and no other decimals than can-utils writes.
bool IsOurs(std::string_view line, const hil::LogFrame& frame) {
  const std::size_t decimals = line.find(')') - line.find('.') - 1;
  return !frame.fd && (decimals == 6 || decimals == 9) && line.find('_') == std::string_view::npos;
}

/// What both readers must say of one line.
void RequireAgreement(std::string_view line) {
  const Result<can::CandumpLine> ours = can::ParseCandump(line);
  hil::ChannelNames channels;
  hil::LogFrame frame;
  const hil::LineMeaning meaning = hil::ReadCandumpLogLine(line, channels, frame);
  if (!ours.ok()) {
    Require(meaning.kind != hil::LineMeaning::Kind::kFrame || !IsOurs(line, frame),
            "both readers refuse the line");
    return;
  }
  Require(meaning.kind == hil::LineMeaning::Kind::kFrame, "both readers take the line");
  Require(hil::ClassicFrame(frame) == ours->frame, "both readers see one frame");
  Require(Time(Duration(frame.stamp_ns)) == ours->frame.stamp, "both readers see one time");
}

/// A frame that is written and read again is the same, its time cut to microseconds.
void RequireRoundTrip(const can::CandumpLine& line) {
  char text[can::kCandumpLineBytes];
  const Result<int> length = can::FormatCandump(line.frame, line.interface, text);
  if (!length.ok()) {
    return;  // a longer interface than Linux has
  }
  const auto again = can::ParseCandump({text, static_cast<std::size_t>(*length - 1)});
  Require(again.ok() && again->frame == line.frame && again->interface == line.interface,
          "what is written is read again");
  const auto us = [](Time t) { return t.time_since_epoch().count() / 1000; };
  Require(us(again->frame.stamp) == us(line.frame.stamp), "the time is read again");
}

void ReadLines(std::string_view text) {
  can::CandumpReader reader(text);
  while (true) {
    const Result<can::CandumpLine> line = reader.Next();
    if (line.status() == Status::kUnavailable) {
      return;
    }
    if (line.ok()) {
      RequireRoundTrip(*line);
    }
  }
}

}  // namespace
}  // namespace pipewright::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace pipewright;
  if (size == 0) {
    return 0;
  }
  const std::string_view text(reinterpret_cast<const char*>(bytes) + 1, size - 1);
  test::ReadLines(text);
  for (std::string_view rest = text; !rest.empty();) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    test::RequireAgreement(line);
  }
  test::ReadWholeLog(bytes + 1, size - 1, (bytes[0] & 1) != 0);
  return 0;
}
