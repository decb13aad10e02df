// SPDX-License-Identifier: MIT
#include "perception/primitives/pixel_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "platform/core/rng.h"

namespace pipewright {
namespace {

TEST(SweepDistances, EqualTheChessboardDistanceToEverySeedOfTheBox) {
  Rng rng(9);
  for (int k = 0; k < 200; ++k) {
    const int width = 1 + rng.Index(30);
    const int height = 1 + rng.Index(20);
    PixelBox box;
    box.row_lo = rng.Index(height);
    box.row_hi = box.row_lo + rng.Index(height - box.row_lo);
    box.column_lo = rng.Index(width);
    box.column_hi = box.column_lo + rng.Index(width - box.column_lo);
    std::vector<std::uint8_t> image(static_cast<std::size_t>(width * height));
    for (std::uint8_t& pixel : image) {
      pixel = rng.Index(20) == 0 ? 0 : 255;
    }
    const std::vector<std::uint8_t> seeds = image;
    SweepDistances(image, width, box);
    for (int i = 0; i < width * height; ++i) {
      const int row = i / width;
      const int column = i % width;
      const bool inside = row >= box.row_lo && row <= box.row_hi && column >= box.column_lo &&
                          column <= box.column_hi;
      int least = inside ? 255 : seeds[i];
      for (int r = box.row_lo; inside && r <= box.row_hi; ++r) {
        for (int c = box.column_lo; c <= box.column_hi; ++c) {
          if (seeds[r * width + c] == 0) {
            least = std::min(least, std::max(std::abs(r - row), std::abs(c - column)));
          }
        }
      }
      ASSERT_EQ(image[i], least) << "row " << row << ", column " << column;
    }
  }
}

}  // namespace
}  // namespace pipewright
