// SPDX-License-Identifier: MIT
#include "hil/canlog/candump_lines.h"

#include <chrono>

#include "hil/canlog/line_scanner.h"

namespace pipewright::hil {
namespace {

constexpr std::uint64_t kFdBitrateSwitch = 1;
constexpr std::uint64_t kFdErrorPassive = 2;
constexpr int kClassicBytes = 8;
constexpr int kFdBytes = 64;

constexpr const char* kId = "an id of 3 or 8 hex digits";
constexpr const char* kClassicPayload = "at most 8 bytes in pairs of hex digits";
constexpr const char* kFdPayload = "a flag digit and a CAN FD payload in pairs of hex digits";

// --- candump -L ---

const char* TakeRemote(LineScanner& in, LogFrame& frame) {
  std::uint64_t length = 0;
  in.Decimal(1, length);
  frame.remote = true;
  frame.length = static_cast<std::uint8_t>(length);
  return length <= kClassicBytes ? nullptr : "a remote frame of at most 8 bytes";
}

const char* TakeFd(LineScanner& in, LogFrame& frame) {
  std::uint64_t flags = 0;
  if (in.Hex(1, flags) != 1) {
    return kFdPayload;
  }
  const int bytes = in.HexPairs(frame.data.data(), kFdBytes);
  frame.fd = true;
  frame.bitrate_switch = (flags & kFdBitrateSwitch) != 0;
  frame.error_passive = (flags & kFdErrorPassive) != 0;
  frame.length = static_cast<std::uint8_t>(bytes);
  return IsFdLength(bytes) ? nullptr : kFdPayload;
}

const char* TakeClassic(LineScanner& in, LogFrame& frame) {
  const int bytes = in.HexPairs(frame.data.data(), kClassicBytes);
  frame.length = static_cast<std::uint8_t>(bytes);
  return bytes >= 0 ? nullptr : kClassicPayload;
}

void TakeDirection(LineScanner& in, LogFrame& frame) {
  in.SkipSpaces();
  const std::string_view word = in.Word();
  if (word == "R" || word == "T") {
    frame.direction = word == "R" ? LogDirection::kReceived : LogDirection::kSent;
  }
}

const char* TakeLogFrame(LineScanner& in, LogFrame& frame) {
  if (!TakeCanUtilsId(in, frame) || !in.Take('#')) {
    return "an id of 3 or 8 hex digits and '#'";
  }
  const char* const expected = in.Take('R')   ? TakeRemote(in, frame)
                               : in.Take('#') ? TakeFd(in, frame)
                                              : TakeClassic(in, frame);
  if (expected != nullptr) {
    return expected;
  }
  std::uint64_t length_code = 0;
  if (in.Take('_') && (in.Hex(1, length_code) != 1 || frame.fd)) {
    return "a length code after '_'";
  }
  if (!in.AtSpaceOrEnd()) {
    return frame.fd ? kFdPayload : kClassicPayload;
  }
  if (!in.AtEnd()) {
    TakeDirection(in, frame);
  }
  return nullptr;
}

// --- candump ---

/// 2023-11-03 09:26:40.123456
bool TakeDate(LineScanner& in, std::uint64_t year, std::int64_t& ns) {
  std::uint64_t part[4] = {};  // month, day, hour, minute
  const char before[] = {'-', '-', ' ', ':'};
  for (int i = 0; i < 4; ++i) {
    if (!in.Take(before[i]) || in.Decimal(2, part[i]) != 2) {
      return false;
    }
  }
  namespace chrono = std::chrono;
  const chrono::year_month_day date{chrono::year(static_cast<int>(year)),
                                    chrono::month(static_cast<unsigned>(part[0])),
                                    chrono::day(static_cast<unsigned>(part[1]))};
  if (!in.Take(':') || !in.Seconds(ns) || !date.ok() || part[2] > 23 || part[3] > 59) {
    return false;
  }
  const chrono::seconds before_minute = chrono::sys_days(date).time_since_epoch() +
                                        chrono::hours(static_cast<int>(part[2])) +
                                        chrono::minutes(static_cast<int>(part[3]));
  ns += chrono::nanoseconds(before_minute).count();
  return true;
}

bool TakeStamp(LineScanner& in, LogFrame& frame) {
  LineScanner ahead = in;
  std::uint64_t year = 0;
  if (ahead.Decimal(4, year) == 4 && ahead.front() == '-' && year >= 1970 && year < 2255) {
    in = ahead;
    frame.stamped = TakeDate(in, year, frame.stamp_ns);
  } else {
    frame.stamped = in.Seconds(frame.stamp_ns);
  }
  return frame.stamped && in.Take(')');
}

/// candump -x: direction, then 'B' or '-', 'E' or '-'.
void TakeExtra(LineScanner& in, LogFrame& frame) {
  LineScanner ahead = in;
  const std::string_view word = ahead.Word();
  if (word == "RX" || word == "TX") {
    frame.direction = word == "RX" ? LogDirection::kReceived : LogDirection::kSent;
    frame.bitrate_switch = ahead.Word() == "B";
    frame.error_passive = ahead.Word() == "E";
    in = ahead;
  }
}

/// [8] classic, [08] CAN FD, then perhaps the length code: {F}
bool TakeLength(LineScanner& in, LogFrame& frame) {
  std::uint64_t length = 0;
  in.SkipSpaces();
  const bool opened = in.Take('[');
  const int digits = in.Decimal(2, length);
  if (!opened || digits == 0 || !in.Take(']')) {
    return false;
  }
  frame.fd = digits == 2;
  frame.length = static_cast<std::uint8_t>(length);
  if (in.front() == '{') {
    in.Word();
  }
  return frame.fd ? IsFdLength(static_cast<int>(length)) : length <= kClassicBytes;
}

bool TakeSpacedPayload(LineScanner& in, LogFrame& frame) {
  for (int i = 0; i < frame.length; ++i) {
    std::uint64_t byte = 0;
    in.SkipSpaces();
    if (in.Hex(2, byte) != 2 || !in.AtSpaceOrEnd()) {
      return false;
    }
    frame.data[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(byte);
  }
  return true;
}

}  // namespace

LineMeaning ReadCandumpLogLine(std::string_view line, ChannelNames& channels, LogFrame& frame) {
  Clear(frame);
  LineScanner in(line);
  if (line.empty() || line.front() == '#') {
    return LineMeaning::Nothing();
  }
  if (!in.Take('(') || !in.Seconds(frame.stamp_ns) || !in.Take(')') || !in.AtSpaceOrEnd()) {
    return LineMeaning::Malformed("a time such as (1699000000.123456)");
  }
  frame.stamped = true;
  in.SkipSpaces();
  const std::string_view interface = in.Word();
  if (interface.empty()) {
    return LineMeaning::Malformed("an interface after the time");
  }
  if (const char* const expected = TakeLogFrame(in, frame)) {
    return LineMeaning::Malformed(expected);
  }
  frame.channel = channels.Number(interface);
  return LineMeaning::Frame();
}

LineMeaning ReadCandumpLine(std::string_view line, ChannelNames& channels, LogFrame& frame) {
  Clear(frame);
  LineScanner in(line);
  in.SkipSpaces();
  if (in.AtEnd() || line.front() == '\t') {  // -e explains an error message on lines with a tab
    return LineMeaning::Nothing();
  }
  if (in.Take('(') && !TakeStamp(in, frame)) {
    return LineMeaning::Malformed("a time such as (1699000000.123456)");
  }
  in.SkipSpaces();
  const std::string_view interface = in.Word();
  TakeExtra(in, frame);
  if (interface.empty() || !TakeCanUtilsId(in, frame)) {
    return LineMeaning::Malformed(interface.empty() ? "an interface" : kId);
  }
  if (!TakeLength(in, frame)) {
    return LineMeaning::Malformed("a length such as [8], or [08] of CAN FD");
  }
  in.SkipSpaces();
  frame.remote = !frame.fd && in.rest().starts_with("remote request");
  if (!frame.remote && !TakeSpacedPayload(in, frame)) {
    return LineMeaning::Malformed("as many bytes of two hex digits as the length says");
  }
  frame.channel = channels.Number(interface);
  return LineMeaning::Frame();
}

}  // namespace pipewright::hil
