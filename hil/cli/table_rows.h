// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <string>

namespace pipewright::hil {

/// A short table for people: names, and what is to be said of each.
struct TableRows {
  std::string text;

  void operator()(const std::string& name, const std::string& value) {
    text += fmt::format("  {:<12} {}\n", name, value);
  }
};

}  // namespace pipewright::hil
