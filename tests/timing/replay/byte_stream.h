// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstdio>

namespace pipewright::timing {

/// FNV-1a over the bytes of a stream: tells a file that was cut or changed from a whole one.
class ByteHash {
 public:
  void Add(std::uint8_t byte) { value_ = (value_ ^ byte) * 0x100000001B3U; }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325U;
};

/// Numbers to a file, low byte first, whatever the machine's own order: integers at their size
/// (never `long`, whose size is the machine's), doubles as their 64 bits, bool as one byte.
class ByteWriter {
 public:
  static constexpr bool kReads = false;

  explicit ByteWriter(std::FILE* file) : file_(file) {}

  template <std::integral T>
  void Pass(const T& value) {
    auto bits = static_cast<std::uint64_t>(value);
    for (unsigned i = 0; i < sizeof(T); ++i, bits >>= 8) {
      Put(static_cast<std::uint8_t>(bits & 0xFF));
    }
  }
  void Pass(const double& value) { Pass(std::bit_cast<std::uint64_t>(value)); }

  bool ok() const { return ok_; }
  std::uint64_t hash() const { return hash_.value(); }

 private:
  void Put(std::uint8_t byte) {
    hash_.Add(byte);
    ok_ = std::fputc(byte, file_) != EOF && ok_;
  }

  std::FILE* file_;
  bool ok_ = true;
  ByteHash hash_;
};

/// The same back. The first problem sticks: from then on every number reads as zero.
class ByteReader {
 public:
  static constexpr bool kReads = true;

  explicit ByteReader(std::FILE* file) : file_(file) {}

  template <std::integral T>
  void Pass(T& value) {
    std::uint64_t bits = 0;
    for (unsigned i = 0; i < sizeof(T); ++i) {
      bits |= static_cast<std::uint64_t>(Take()) << (8 * i);
    }
    if constexpr (std::same_as<T, bool>) {
      if (bits > 1) {
        Fail("a flag is neither 0 nor 1");
      }
    }
    value = problem_ == nullptr ? static_cast<T>(bits) : T{};
  }
  void Pass(double& value) {
    std::uint64_t bits = 0;
    Pass(bits);
    value = std::bit_cast<double>(bits);
    if (!std::isfinite(value)) {
      Fail("a number is not finite");
      value = 0;
    }
  }

  void Fail(const char* problem) { problem_ = problem_ == nullptr ? problem : problem_; }
  bool ok() const { return problem_ == nullptr; }
  const char* problem() const { return problem_; }  ///< nullptr: none
  std::int64_t offset() const { return offset_; }   ///< bytes read so far
  std::uint64_t hash() const { return hash_.value(); }

 private:
  std::uint8_t Take() {
    const int byte = problem_ == nullptr ? std::fgetc(file_) : EOF;
    if (byte == EOF) {
      Fail("it ends early");
      return 0;
    }
    ++offset_;
    hash_.Add(static_cast<std::uint8_t>(byte));
    return static_cast<std::uint8_t>(byte);
  }

  std::FILE* file_;
  const char* problem_ = nullptr;
  std::int64_t offset_ = 0;
  ByteHash hash_;
};

}  // namespace pipewright::timing
