// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

namespace pipewright::hil {

/// lo <= x <= hi. Unlike CLI::Range it refuses what is not a number, too.
inline CLI::Validator InRange(double lo, double hi) {
  const auto check = [lo, hi](std::string& text) -> std::string {
    double x = 0;
    const bool fits = CLI::detail::lexical_cast(text, x) && lo <= x && x <= hi;
    return fits ? "" : fmt::format("{} is not from {} to {}", text, lo, hi);
  };
  return CLI::Validator(check, fmt::format("in [{} - {}]", lo, hi));
}

}  // namespace pipewright::hil
