// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstring>
#include <string>
#include <type_traits>

namespace pipewright::hil {

static_assert(std::endian::native == std::endian::little, "numbers are given as they lie");

/// Adds a number's bytes, the low one first.
template <typename Number>
void AppendNumber(std::string& to, Number value) {
  static_assert(std::is_arithmetic_v<Number>);
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  to.append(bytes, sizeof value);
}

}  // namespace pipewright::hil
