// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

namespace pipewright {

/// Part of an image, rows and columns from lo to hi, both included.
struct PixelBox {
  int row_lo = 0;
  int row_hi = -1;
  int column_lo = 0;
  int column_hi = -1;
};

/// Chessboard distance [pixels] to the nearest pixel whose value is 0, in place, by two sweeps over
/// a box of an image of so many columns. Others come in with more than the largest distance asked.
void SweepDistances(std::span<std::uint8_t> image, int width, const PixelBox& box);

}  // namespace pipewright
