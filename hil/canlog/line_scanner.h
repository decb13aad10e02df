// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "hil/canlog/log_frame.h"

namespace pipewright::hil {

/// What a hex digit counts; 16 for any other character.
inline constexpr std::array<std::uint8_t, 256> kHexDigit = [] {
  std::array<std::uint8_t, 256> digit{};
  digit.fill(16);
  for (std::uint8_t i = 0; i < 10; ++i) {
    digit[static_cast<std::size_t>('0' + i)] = i;
  }
  for (std::uint8_t i = 0; i < 6; ++i) {
    digit[static_cast<std::size_t>('A' + i)] = static_cast<std::uint8_t>(10 + i);
    digit[static_cast<std::size_t>('a' + i)] = static_cast<std::uint8_t>(10 + i);
  }
  return digit;
}();

constexpr std::uint8_t HexDigit(char c) { return kHexDigit[static_cast<unsigned char>(c)]; }
constexpr bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\r'; }
constexpr bool IsDigit(char c) { return '0' <= c && c <= '9'; }

/// Takes a line apart from its front.
class LineScanner {
 public:
  explicit LineScanner(std::string_view line) : at_(line.data()), end_(at_ + line.size()) {}

  bool AtEnd() const { return at_ == end_; }
  bool AtSpaceOrEnd() const { return at_ == end_ || IsSpace(*at_); }
  char front() const { return at_ == end_ ? '\0' : *at_; }
  std::string_view rest() const { return {at_, static_cast<std::size_t>(end_ - at_)}; }

  bool Take(char c) {
    if (at_ == end_ || *at_ != c) {
      return false;
    }
    ++at_;
    return true;
  }
  void SkipSpaces() {
    while (at_ != end_ && IsSpace(*at_)) {
      ++at_;
    }
  }
  /// Up to the next space, and the spaces after it.
  std::string_view Word() {
    const char* const from = at_;
    while (at_ != end_ && !IsSpace(*at_)) {
      ++at_;
    }
    const std::string_view word(from, static_cast<std::size_t>(at_ - from));
    SkipSpaces();
    return word;
  }
  /// Up to `most` hex digits, at most 16. @returns how many
  int Hex(int most, std::uint64_t& value) {
    value = 0;
    int digits = 0;
    for (; digits < most && at_ != end_ && HexDigit(*at_) < 16; ++digits, ++at_) {
      value = value << 4 | HexDigit(*at_);
    }
    return digits;
  }
  /// Up to `most` decimal digits, at most 18. @returns how many
  int Decimal(int most, std::uint64_t& value) {
    value = 0;
    int digits = 0;
    for (; digits < most && at_ != end_ && IsDigit(*at_); ++digits, ++at_) {
      value = value * 10 + static_cast<std::uint64_t>(*at_ - '0');
    }
    return digits;
  }
  /// Seconds with 1 to 9 decimals, in nanoseconds; seconds below 9e9.
  bool Seconds(std::int64_t& ns);
  /// Pairs of hex digits that follow each other. @returns how many bytes, or -1: more than `most`
  int HexPairs(std::uint8_t* to, int most) {
    int bytes = 0;
    for (; end_ - at_ >= 2; at_ += 2, ++bytes) {
      const std::uint8_t high = HexDigit(at_[0]);
      const std::uint8_t low = HexDigit(at_[1]);
      if ((high | low) >= 16) {
        break;
      }
      if (bytes == most) {
        return -1;
      }
      to[bytes] = static_cast<std::uint8_t>(high << 4 | low);
    }
    return bytes;
  }

 private:
  const char* at_;
  const char* end_;
};

/// An id as can-utils writes it: 3 hex digits have 11 bits; 8 have 29, or are an error message's
/// class bits with bit 29 set.
bool TakeCanUtilsId(LineScanner& in, LogFrame& frame);

/// Lengths that a payload of CAN FD can have.
constexpr bool IsFdLength(int bytes) {
  return (0 <= bytes && bytes <= 8) || bytes == 12 || bytes == 16 || bytes == 20 || bytes == 24 ||
         bytes == 32 || bytes == 48 || bytes == 64;
}

/// All but the payload past its first 8 bytes, which stays as it is: clearing it would cost more
/// than reading a line.
inline void Clear(LogFrame& frame) {
  frame.stamp_ns = 0;
  frame.id = 0;
  frame.length = 0;
  frame.channel = 0;
  frame.stamped = false;
  frame.extended = false;
  frame.remote = false;
  frame.error = false;
  frame.fd = false;
  frame.bitrate_switch = false;
  frame.error_passive = false;
  frame.direction = LogDirection::kUnknown;
  std::fill_n(frame.data.begin(), 8, std::uint8_t{0});
}

}  // namespace pipewright::hil
