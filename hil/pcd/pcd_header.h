// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace pipewright::hil {

enum class PcdData : unsigned char { kAscii, kBinary, kCompressed };

struct PcdField {
  std::string name;
  int size = 0;   ///< bytes of one value: 1, 2, 4, 8
  char type = 0;  ///< 'F', 'I', 'U'
  int count = 1;  ///< values a point
};

/// What stands before the points.
struct PcdHeader {
  std::vector<PcdField> fields;
  int width = 0;
  int height = 0;
  PcdData data = PcdData::kAscii;
  std::size_t body = 0;  ///< the byte at which the points begin
  int lines = 0;         ///< of the header
  std::string error;     ///< empty, or in words with the line

  std::size_t points() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  std::size_t point_bytes() const;
  /// Index of a field, or -1.
  int Find(std::string_view name) const;
};

PcdHeader ParsePcdHeader(std::string_view bytes);

}  // namespace pipewright::hil
