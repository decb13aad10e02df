// SPDX-License-Identifier: MIT
#include "hil/canlog/byte_window.h"

#include <algorithm>

namespace pipewright::hil {

void ByteWindow::Refill() {
  std::memmove(buffer_.get(), buffer_.get() + begin_, end_ - begin_);
  before_ += begin_;
  end_ -= begin_;
  begin_ = 0;
  end_ += source_.Read({buffer_.get() + end_, kBytes - end_});
}

ByteWindow::LineKind ByteWindow::SlowLine(std::string_view& line) {
  std::string_view rest = Peek(kMostLine);
  if (rest.find('\n') != std::string_view::npos) {
    return Line(line);
  }
  line = rest;
  if (rest.empty()) {
    return LineKind::kEnd;
  }
  ++lines_;
  if (rest.size() < kMostLine) {
    begin_ = end_;
    return LineKind::kCut;
  }
  // The rest of the line goes unseen. Its beginning would be overwritten: it is shown up to there.
  line = {};
  while (true) {
    const std::size_t feed = rest.find('\n');
    if (feed != std::string_view::npos) {
      begin_ += feed + 1;
      return LineKind::kTooLong;
    }
    begin_ += rest.size();
    rest = Peek(kMostLine);
    if (rest.empty()) {
      return LineKind::kCut;
    }
  }
}

std::uint64_t ByteWindow::Skip(std::uint64_t bytes) {
  std::uint64_t skipped = 0;
  while (skipped < bytes) {
    if (begin_ == end_) {
      Refill();
      if (end_ == 0) {
        break;
      }
    }
    const std::uint64_t step = std::min<std::uint64_t>(bytes - skipped, end_ - begin_);
    begin_ += step;
    skipped += step;
  }
  return skipped;
}

}  // namespace pipewright::hil
