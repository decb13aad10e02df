// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstring>
#include <memory>
#include <string_view>

#include "hil/canlog/byte_source.h"

namespace pipewright::hil {

/// A window of fixed size that moves over a source from front to back: whole lines for texts, runs
/// of bytes for binary files. What it gives is valid until the next call.
class ByteWindow {
 public:
  static constexpr std::size_t kBytes = 256 * 1024;
  static constexpr std::size_t kMostLine = 4096;

  explicit ByteWindow(ByteSource& source)
      : source_(source), buffer_(std::make_unique<char[]>(kBytes)) {}

  enum class LineKind {
    kWhole,
    kTooLong,  ///< kMostLine or longer: passed over
    kCut,      ///< the data end before a line feed does; empty: and it is too long
    kEnd,      ///< nothing is left
  };

  /// The next line, without its line feed and a carriage return before that.
  LineKind Line(std::string_view& line) {
    const char* const from = buffer_.get() + begin_;
    const std::size_t most = end_ - begin_ < kMostLine ? end_ - begin_ : kMostLine;
    const void* const feed = std::memchr(from, '\n', most);
    if (feed == nullptr) {
      return SlowLine(line);
    }
    std::size_t length = static_cast<std::size_t>(static_cast<const char*>(feed) - from);
    begin_ += length + 1;
    ++lines_;
    length -= length > 0 && from[length - 1] == '\r' ? 1 : 0;
    line = {from, length};
    return LineKind::kWhole;
  }

  /// The next `bytes` bytes, or as many as there are, without moving on. @pre bytes <= kBytes
  std::string_view Peek(std::size_t bytes) {
    if (end_ - begin_ < bytes) {
      Refill();
    }
    return {buffer_.get() + begin_, bytes < end_ - begin_ ? bytes : end_ - begin_};
  }
  /// Moves on, beyond the window too. @returns how many bytes there were to skip
  std::uint64_t Skip(std::uint64_t bytes);

  std::uint64_t lines() const { return lines_; }  ///< begun
  std::uint64_t position() const { return before_ + begin_; }
  const ByteSource& source() const { return source_; }

 private:
  LineKind SlowLine(std::string_view& line);
  /// Moves what is left to the front and reads on behind it.
  void Refill();

  ByteSource& source_;
  std::unique_ptr<char[]> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint64_t before_ = 0;  ///< bytes of the source before buffer_[0]
  std::uint64_t lines_ = 0;
};

}  // namespace pipewright::hil
