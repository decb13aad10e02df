// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace pipewright::hil {

/// What of a log could not be read. Reading goes on after a record that makes no sense: all are
/// counted, the first few are told in words.
class LogProblems {
 public:
  static constexpr std::size_t kTold = 5;

  /// `where`: "line 12", "byte 4711".
  void Malformed(std::string where, const char* expected, std::string_view found);
  /// The log ends within a record, or cannot be read further. What is told last is kept: that a
  /// file is cut explains the line that is.
  void EndsEarly(std::string why) { end_ = std::move(why); }

  std::uint64_t malformed() const { return malformed_; }
  const std::vector<std::string>& told() const { return told_; }
  const std::string& end() const { return end_; }  ///< why it ends early; empty if it does not
  bool none() const { return malformed_ == 0 && end_.empty(); }

 private:
  std::uint64_t malformed_ = 0;
  std::vector<std::string> told_;
  std::string end_;
};

}  // namespace pipewright::hil
