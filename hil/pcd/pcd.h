// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pipewright::hil {

/// The points of a PCD file, in its own frame. Those without a reading are NaN.
struct PcdCloud {
  int width = 0;  ///< times height is the number of points; height 1: not organised
  int height = 0;
  std::vector<Eigen::Vector3f> points;  ///< row-major
};

struct PcdResult {
  std::optional<PcdCloud> cloud;  ///< whole and as documented, or nothing
  std::string error;  ///< in words: the file, and the line or byte and the field that is wrong
};

/// A PCD file of version 0.6 or 0.7: header lines VERSION, FIELDS, SIZE, TYPE, COUNT, WIDTH,
/// HEIGHT, VIEWPOINT, POINTS, DATA, then the points as
///
///   ascii               one a line, fields parted by blanks
///   binary              one after the other, little-endian
///   binary_compressed   uint32 packed size, uint32 size, then, packed by LZF, field after field
///
/// Fields x, y, z must be there as one float or double each; others are passed over. VIEWPOINT and
/// VERSION are read and not used. Memory follows the size of the file, not what its counts claim.
PcdResult ReadPcd(const std::filesystem::path& path);

}  // namespace pipewright::hil
