// SPDX-License-Identifier: MIT
#include "hil/canlog/log_problems.h"

#include <fmt/format.h>

namespace pipewright::hil {
namespace {

constexpr std::size_t kShownBytes = 60;

/// Safe to print on a terminal, whatever a log holds.
std::string Shown(std::string_view text) {
  std::string shown;
  for (const char c : text.substr(0, kShownBytes)) {
    shown += ' ' <= c && c <= '~' ? c : c == '\t' ? ' ' : '?';
  }
  return shown + (text.size() > kShownBytes ? "..." : "");
}

}  // namespace

void LogProblems::Malformed(std::string where, const char* expected, std::string_view found) {
  ++malformed_;
  if (told_.size() < kTold) {
    told_.push_back(found.empty()
                        ? fmt::format("{}: expected {}", where, expected)
                        : fmt::format("{}: expected {}: '{}'", where, expected, Shown(found)));
  }
}

}  // namespace pipewright::hil
