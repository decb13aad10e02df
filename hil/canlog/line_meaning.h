// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace pipewright::hil {

/// What a line of a log is; if it makes no sense, what was expected in its place.
struct LineMeaning {
  enum class Kind : std::uint8_t {
    kFrame,
    kNothing,  ///< a comment, a header, an event of another kind
    kMalformed,
  };
  Kind kind = Kind::kFrame;
  const char* expected = nullptr;

  static LineMeaning Frame() { return {}; }
  static LineMeaning Nothing() { return {Kind::kNothing, nullptr}; }
  static LineMeaning Malformed(const char* expected) { return {Kind::kMalformed, expected}; }
};

}  // namespace pipewright::hil
