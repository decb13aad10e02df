// SPDX-License-Identifier: MIT
#include "perception/primitives/thinning.h"

#include <cassert>
#include <cmath>

namespace pipewright {
namespace {

/// Past it, a point's cube could not be told in 32 bits.
constexpr float kMaxCube = 1e9F;

}  // namespace

/// @returns whether the cube was not there yet
bool Thinning::Insert(const Eigen::Vector3i& cube) {
  std::uint32_t hash = static_cast<std::uint32_t>(cube.x()) * 0x9E3779B1U ^
                       static_cast<std::uint32_t>(cube.y()) * 0x85EBCA77U ^
                       static_cast<std::uint32_t>(cube.z()) * 0xC2B2AE3DU;
  hash ^= hash >> 15;
  for (;; ++hash) {  // ends, for at most a quarter of the slots is filled
    Slot& slot = slots_[hash % kSlots];
    if (slot.try_number != try_number_) {
      slot = {try_number_, cube};
      return true;
    }
    if (slot.cube == cube) {
      return false;
    }
  }
}

/// @returns -1 when there is no room
int Thinning::PickOfCubes(std::span<const Eigen::Vector3f> points, float width_m,
                          std::span<int> picked) {
  ++try_number_;
  int count = 0;
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    const Eigen::Vector3f cube = (points[i] / width_m).array().floor();
    // A comparison with NaN is false.
    if (!(cube.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() < kMaxCube) ||
        !Insert(cube.cast<int>())) {
      continue;
    }
    if (count == kMaxPoints) {
      return -1;
    }
    picked[count++] = i;
  }
  return count;
}

int Thinning::Pick(std::span<const Eigen::Vector3f> points, float width_m, std::span<int> picked) {
  assert(width_m > 0 && picked.size() >= kMaxPoints);
  int count = 0;
  for (int i = 0; i < static_cast<int>(points.size()) && count <= kMaxPoints; ++i) {
    if (points[i].allFinite()) {
      if (count < kMaxPoints) {
        picked[count] = i;
      }
      ++count;
    }
  }
  if (count <= kMaxPoints) {
    return count;
  }
  while ((count = PickOfCubes(points, width_m, picked)) < 0) {
    width_m *= 1.25F;
  }
  return count;
}

}  // namespace pipewright
