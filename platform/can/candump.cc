// SPDX-License-Identifier: MIT
#include "platform/can/candump.h"

#include <algorithm>
#include <cstdint>

namespace pipewright::can {
namespace {

constexpr std::uint32_t kErrorFlag = 0x20000000;
constexpr std::uint32_t kIdMask = 0x1FFFFFFF;

/// Text into a fixed buffer; what does not fit is remembered, not written.
class Writer {
 public:
  explicit Writer(std::span<char> out) : out_(out) {}

  void Put(char c) {
    if (length_ < out_.size()) {
      out_[length_] = c;
    }
    ++length_;
  }
  void Put(std::string_view text) {
    for (const char c : text) {
      Put(c);
    }
  }
  void PutDigits(std::uint64_t value, std::uint64_t base, int digits) {
    std::uint64_t place = 1;
    for (int i = 1; i < digits || value / place >= base; ++i) {
      place *= base;
    }
    for (; place > 0; place /= base) {
      Put("0123456789ABCDEF"[value / place % base]);
    }
  }
  Result<int> Length() const {
    if (length_ > out_.size()) {
      return Status::kFull;
    }
    return static_cast<int>(length_);
  }

 private:
  std::span<char> out_;
  std::size_t length_ = 0;
};

int DigitValue(char c) {
  if ('0' <= c && c <= '9') {
    return c - '0';
  }
  if ('a' <= c && c <= 'f') {
    return c - 'a' + 10;
  }
  if ('A' <= c && c <= 'F') {
    return c - 'A' + 10;
  }
  return 16;
}

/// Takes text apart from its front.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : rest_(text) {}

  bool Take(char c) {
    if (rest_.empty() || rest_.front() != c) {
      return false;
    }
    rest_.remove_prefix(1);
    return true;
  }
  bool AtEnd() const { return rest_.empty(); }
  bool AtSpace() const {
    return !rest_.empty() &&
           (rest_.front() == ' ' || rest_.front() == '\t' || rest_.front() == '\r');
  }
  void SkipSpaces() {
    while (AtSpace()) {
      rest_.remove_prefix(1);
    }
  }
  std::string_view Word() {
    const std::size_t length = std::min(rest_.find_first_of(" \t\r"), rest_.size());
    const std::string_view word = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return word;
  }
  /// Up to `most` digits; returns how many, 0 to most.
  int Digits(int base, int most, std::uint64_t& value) {
    int count = 0;
    value = 0;
    while (count < most && !rest_.empty() && DigitValue(rest_.front()) < base) {
      value = value * static_cast<std::uint64_t>(base) +
              static_cast<std::uint64_t>(DigitValue(rest_.front()));
      rest_.remove_prefix(1);
      ++count;
    }
    return count;
  }

 private:
  std::string_view rest_;
};

bool TakeStamp(Scanner& in, Time& stamp) {
  std::uint64_t seconds = 0;
  std::uint64_t fraction = 0;
  if (!in.Take('(') || in.Digits(10, 10, seconds) == 0 || seconds > 9'000'000'000U ||
      !in.Take('.')) {
    return false;
  }
  const int decimals = in.Digits(10, 9, fraction);
  if ((decimals != 6 && decimals != 9) || !in.Take(')')) {
    return false;
  }
  const std::uint64_t nanoseconds = decimals == 6 ? fraction * 1000 : fraction;
  stamp = Time(Duration(static_cast<std::int64_t>(seconds * 1'000'000'000U + nanoseconds)));
  return true;
}

bool TakeId(Scanner& in, Frame& frame) {
  std::uint64_t id = 0;
  const int digits = in.Digits(16, 8, id);
  frame.id = static_cast<std::uint32_t>(id);
  if (digits == 3) {
    return frame.id <= 0x7FF;
  }
  if (digits != 8) {
    return false;
  }
  frame.error = (frame.id & kErrorFlag) != 0;
  frame.extended = !frame.error;
  frame.id &= ~kErrorFlag;
  return frame.id <= kIdMask;
}

bool TakePayload(Scanner& in, Frame& frame) {
  std::uint64_t value = 0;
  if (in.Take('R')) {
    frame.remote = true;
    in.Digits(10, 1, value);
    frame.dlc = static_cast<std::uint8_t>(value);
    return value <= 8;
  }
  while (!in.AtEnd() && !in.AtSpace()) {
    if (frame.dlc == 8 || in.Digits(16, 2, value) != 2) {
      return false;
    }
    frame.data[frame.dlc++] = static_cast<std::uint8_t>(value);
  }
  return true;
}

}  // namespace

Result<int> FormatCandump(const Frame& frame, std::string_view interface, std::span<char> out) {
  const std::int64_t ns = frame.stamp.time_since_epoch().count();
  if (interface.empty() || interface.size() > static_cast<std::size_t>(kInterfaceNameBytes) ||
      interface.find_first_of(" \t\r\n") != std::string_view::npos || frame.dlc > 8 || ns < 0 ||
      frame.id > (frame.extended || frame.error ? kIdMask : 0x7FFU)) {
    return Status::kMalformed;
  }
  const auto stamp = static_cast<std::uint64_t>(ns);
  Writer text(out);
  text.Put('(');
  text.PutDigits(stamp / 1'000'000'000U, 10, 10);
  text.Put('.');
  text.PutDigits(stamp % 1'000'000'000U / 1000, 10, 6);
  text.Put(") ");
  text.Put(interface);
  text.Put(' ');
  text.PutDigits(frame.error ? frame.id | kErrorFlag : frame.id, 16,
                 frame.extended || frame.error ? 8 : 3);
  text.Put('#');
  if (frame.remote) {
    text.Put('R');
    if (frame.dlc > 0) {
      text.PutDigits(frame.dlc, 10, 1);
    }
  }
  for (int i = 0; i < frame.dlc && !frame.remote; ++i) {
    text.PutDigits(frame.data[i], 16, 2);
  }
  text.Put('\n');
  return text.Length();
}

Result<CandumpLine> ParseCandump(std::string_view line) {
  CandumpLine result;
  Scanner in(line);
  if (!TakeStamp(in, result.frame.stamp) || !in.AtSpace()) {
    return Status::kMalformed;
  }
  in.SkipSpaces();
  result.interface = in.Word();
  in.SkipSpaces();
  if (result.interface.empty() || !TakeId(in, result.frame) || !in.Take('#') ||
      !TakePayload(in, result.frame) || !(in.AtEnd() || in.AtSpace())) {
    return Status::kMalformed;
  }
  return result;
}

Result<CandumpLine> CandumpReader::Next() {
  while (!rest_.empty()) {
    const std::size_t length = std::min(rest_.find('\n'), rest_.size());
    const std::string_view line = rest_.substr(0, length);
    rest_.remove_prefix(std::min(length + 1, rest_.size()));
    ++line_;
    if (line.starts_with('(')) {
      return ParseCandump(line);
    }
  }
  return Status::kUnavailable;
}

}  // namespace pipewright::can
