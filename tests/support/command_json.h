// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>

#include "tests/support/command.h"

namespace pipewright::test {

/// What the program printed when asked for JSON: one object and nothing else, and no word of an
/// error.
inline nlohmann::json Parsed(const CommandResult& result, int exit_code = 0) {
  EXPECT_EQ(result.exit_code, exit_code);
  EXPECT_EQ(result.error, "");
  nlohmann::json run = nlohmann::json::parse(result.out, nullptr, /*allow_exceptions=*/false);
  EXPECT_TRUE(run.is_object()) << result.out;
  return run;
}

}  // namespace pipewright::test
