// SPDX-License-Identifier: MIT
#include "perception/primitives/pixel_distance.h"

#include <algorithm>

namespace pipewright {
namespace {

constexpr std::uint8_t StepFrom(std::uint8_t distance) {
  return static_cast<std::uint8_t>(distance + (distance < 255 ? 1 : 0));
}

/// Lowers a row to one more than the least of the three neighbours in the row beside it.
void LowerByRow(std::uint8_t* row, const std::uint8_t* beside, int columns) {
  const auto lower = [&](int c, std::uint8_t least) { row[c] = std::min(row[c], StepFrom(least)); };
  const int last = columns - 1;
  if (columns == 1) {
    lower(0, beside[0]);
    return;
  }
  lower(0, std::min(beside[0], beside[1]));
  for (int c = 1; c < last; ++c) {
    lower(c, std::min({beside[c - 1], beside[c], beside[c + 1]}));
  }
  lower(last, std::min(beside[last - 1], beside[last]));
}

}  // namespace

void SweepDistances(std::span<std::uint8_t> image, int width, const PixelBox& box) {
  const int columns = box.column_hi - box.column_lo + 1;
  const auto row_at = [&](int row) { return image.data() + row * width + box.column_lo; };
  for (int row = box.row_lo; row <= box.row_hi; ++row) {
    std::uint8_t* here = row_at(row);
    if (row > box.row_lo) {
      LowerByRow(here, row_at(row - 1), columns);
    }
    for (int c = 1; c < columns; ++c) {
      here[c] = std::min(here[c], StepFrom(here[c - 1]));
    }
  }
  for (int row = box.row_hi; row >= box.row_lo; --row) {
    std::uint8_t* here = row_at(row);
    if (row < box.row_hi) {
      LowerByRow(here, row_at(row + 1), columns);
    }
    for (int c = columns - 2; c >= 0; --c) {
      here[c] = std::min(here[c], StepFrom(here[c + 1]));
    }
  }
}

}  // namespace pipewright
