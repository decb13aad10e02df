// SPDX-License-Identifier: MIT
#include "hil/canlog/asc_lines.h"

#include <algorithm>
#include <limits>

namespace pipewright::hil {
namespace {

constexpr std::uint32_t kBusError = 0x80;  // CAN_ERR_BUSERROR
constexpr std::uint8_t kErrorBytes = 8;
constexpr std::uint64_t kFlagRemote = 0x10;
constexpr std::uint64_t kFlagFd = 0x1000;
constexpr std::uint32_t kMost11Bits = 0x7FF;
constexpr std::uint32_t kMost29Bits = 0x1FFFFFFF;
constexpr std::uint64_t kClassicBytes = 8;
constexpr std::uint64_t kMostLengthCode = 15;
constexpr int kMostChannelDigits = 3;
constexpr std::int64_t kLastStamp = std::numeric_limits<std::int64_t>::max();

constexpr const char* kId = "an id, with x behind it if it has 29 bits";
constexpr const char* kPayload = "as many bytes as the length says";

/// Words before which a channel's number stands and which are no frames.
constexpr std::string_view kOtherEvents[] = {"Statistic:", "J1939TP", "OverloadFrame"};
constexpr std::string_view kHeads[] = {
    "date ", "internal events", "no internal events", "Begin ", "End ", "//"};

bool SameLetters(std::string_view word, std::string_view small) {
  return std::equal(word.begin(), word.end(), small.begin(), small.end(),
                    [](char a, char b) { return (a | 0x20) == b; });
}

bool IsErrorFrame(std::string_view word) { return SameLetters(word, "errorframe"); }

LineMeaning ErrorMessage(LogFrame& frame) {
  frame.id = kBusError;
  frame.error = true;
  frame.length = kErrorBytes;
  return LineMeaning::Frame();
}

bool IsNumber(std::string_view word, std::size_t most) {
  return !word.empty() && word.size() <= most && std::all_of(word.begin(), word.end(), IsDigit);
}

bool IsBit(std::string_view word) { return word == "0" || word == "1"; }

/// False: this word is none.
bool TakeDirection(std::string_view word, LogFrame& frame) {
  frame.direction = word == "Rx" ? LogDirection::kReceived : LogDirection::kSent;
  return word == "Rx" || word == "Tx";
}

}  // namespace

bool AscLines::TakeHeader(std::string_view line) {
  if (line.starts_with("base ")) {
    decimal_ = line.find(" dec") != std::string_view::npos;
    relative_ = line.find(" relative") != std::string_view::npos;
    return true;
  }
  return std::any_of(std::begin(kHeads), std::end(kHeads),
                     [line](std::string_view head) { return line.starts_with(head); });
}

LineMeaning AscLines::Read(std::string_view line, ChannelNames& channels, LogFrame& frame) {
  Clear(frame);
  LineScanner in(line);
  in.SkipSpaces();
  if (in.AtEnd() || TakeHeader(in.rest())) {
    return LineMeaning::Nothing();
  }
  if (!in.Seconds(frame.stamp_ns) || !in.AtSpaceOrEnd()) {
    return LineMeaning::Malformed("a time in seconds, such as 0.015991, or a head of ASC");
  }
  if (relative_) {
    // Whatever a log claims, the sum stays a time.
    frame.stamp_ns = last_ns_ + std::min(frame.stamp_ns, kLastStamp - last_ns_);
    last_ns_ = frame.stamp_ns;
  }
  frame.stamped = true;
  in.SkipSpaces();
  const std::string_view channel = in.Word();
  if (channel == "CANFD") {
    return TakeFd(in, channels, frame);
  }
  if (channel.empty()) {
    return LineMeaning::Malformed("an event after the time");
  }
  if (!IsNumber(channel, kMostChannelDigits)) {
    return IsDigit(channel.front()) ? LineMeaning::Malformed("a channel's number")
                                    : LineMeaning::Nothing();
  }
  frame.channel = channels.Number(channel);
  return TakeClassic(in, frame);
}

LineMeaning AscLines::TakeClassic(LineScanner& in, LogFrame& frame) const {
  const std::string_view id = in.Word();
  if (IsErrorFrame(id)) {
    return ErrorMessage(frame);
  }
  if (std::find(std::begin(kOtherEvents), std::end(kOtherEvents), id) != std::end(kOtherEvents)) {
    return LineMeaning::Nothing();
  }
  if (!TakeId(id, frame)) {
    return LineMeaning::Malformed(kId);
  }
  const std::string_view direction = in.Word();
  if (direction == "TxRq") {
    return LineMeaning::Nothing();
  }
  if (!TakeDirection(direction, frame)) {
    return LineMeaning::Malformed("Rx or Tx");
  }
  const std::string_view kind = in.Word();
  frame.remote = kind == "r" || kind == "R";
  if (!frame.remote && kind != "d" && kind != "D") {
    return LineMeaning::Malformed("d or r after the direction");
  }
  std::uint64_t code = 0;
  const int digits = Number(in, 2, code);
  if ((digits == 0 && !frame.remote) || code > kMostLengthCode) {
    return LineMeaning::Malformed("a length code of 0 to 15");
  }
  frame.length = static_cast<std::uint8_t>(std::min(code, kClassicBytes));
  return TakePayload(in, frame) ? LineMeaning::Frame() : LineMeaning::Malformed(kPayload);
}

LineMeaning AscLines::TakeFd(LineScanner& in, ChannelNames& channels, LogFrame& frame) const {
  const std::string_view channel = in.Word();
  if (!IsNumber(channel, kMostChannelDigits) || !TakeDirection(in.Word(), frame)) {
    return LineMeaning::Malformed("a channel's number and Rx or Tx after CANFD");
  }
  const std::string_view id = in.Word();
  frame.channel = channels.Number(channel);
  if (IsErrorFrame(id)) {
    return ErrorMessage(frame);
  }
  if (!TakeId(id, frame)) {
    return LineMeaning::Malformed(kId);
  }
  return TakeFdPayload(in, frame);
}

LineMeaning AscLines::TakeFdPayload(LineScanner& in, LogFrame& frame) const {
  std::string_view rate_switch = in.Word();
  if (!IsBit(rate_switch)) {
    rate_switch = in.Word();  // that was the frame's name
  }
  const std::string_view passive = in.Word();
  LineScanner code(in.Word());
  LineScanner length(in.Word());
  std::uint64_t asked_for = 0;
  std::uint64_t bytes = 0;
  if (!IsBit(rate_switch) || !IsBit(passive) || code.Hex(2, asked_for) == 0 ||
      length.Decimal(2, bytes) == 0 || !length.AtEnd() || !IsFdLength(static_cast<int>(bytes))) {
    return LineMeaning::Malformed("two bits, a length code and a CAN FD length after the id");
  }
  frame.length = static_cast<std::uint8_t>(bytes);
  if (!TakePayload(in, frame)) {
    return LineMeaning::Malformed(kPayload);
  }
  in.SkipSpaces();
  in.Word();  // the frame's duration
  in.Word();  // its bits
  std::uint64_t flags = 0;
  const bool with_flags = in.Hex(8, flags) > 0;
  frame.fd = !with_flags || (flags & kFlagFd) != 0 || bytes > kClassicBytes;
  frame.bitrate_switch = frame.fd && rate_switch == "1";
  frame.error_passive = frame.fd && passive == "1";
  frame.remote = !frame.fd && (flags & kFlagRemote) != 0;
  if (frame.remote) {
    frame.length = static_cast<std::uint8_t>(std::min(asked_for, kClassicBytes));
  }
  return LineMeaning::Frame();
}

bool AscLines::TakeId(std::string_view word, LogFrame& frame) const {
  frame.extended = word.ends_with('x') || word.ends_with('X');
  LineScanner in(word.substr(0, word.size() - (frame.extended ? 1 : 0)));
  std::uint64_t id = 0;
  const int digits = Number(in, decimal_ ? 9 : 8, id);
  frame.id = static_cast<std::uint32_t>(id);
  return digits > 0 && in.AtEnd() && id <= (frame.extended ? kMost29Bits : kMost11Bits);
}

bool AscLines::TakePayload(LineScanner& in, LogFrame& frame) const {
  for (int i = 0; i < frame.payload_bytes(); ++i) {
    std::uint64_t byte = 0;
    in.SkipSpaces();
    if (Number(in, decimal_ ? 3 : 2, byte) == 0 || byte > 0xFF || !in.AtSpaceOrEnd()) {
      return false;
    }
    frame.data[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(byte);
  }
  return true;
}

int AscLines::Number(LineScanner& in, int digits, std::uint64_t& value) const {
  return decimal_ ? in.Decimal(digits, value) : in.Hex(digits, value);
}

}  // namespace pipewright::hil
