// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <iterator>
#include <string_view>

namespace pipewright::hil {

/// Text for standard output, written in large pieces. After the first failure nothing is written.
class TextOut {
 public:
  explicit TextOut(std::FILE* to = stdout) : to_(to) {}

  template <typename... Args>
  void Print(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }
  void Put(std::string_view text) { text_.append(text.begin(), text.end()); }
  fmt::memory_buffer& buffer() { return text_; }

  /// To be called after each record: writes when enough has come together. False: no more goes out.
  bool Continue() { return text_.size() < kEnough ? !failed_ : Flush(); }
  /// False: not everything could be written.
  bool Flush() {
    failed_ = failed_ || std::fwrite(text_.data(), 1, text_.size(), to_) < text_.size() ||
              std::fflush(to_) != 0;
    text_.clear();
    return !failed_;
  }

 private:
  static constexpr std::size_t kEnough = 64 * 1024;

  std::FILE* to_;
  fmt::memory_buffer text_;
  bool failed_ = false;
};

}  // namespace pipewright::hil
