// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

namespace pipewright {

/// Picks points evenly in space, however densely a scanner saw what: the first point of each cube
/// of a grid. Far walls then weigh by their area beside what stood close to the scanner.
class Thinning {
 public:
  static constexpr int kMaxPoints = 1 << 15;  ///< that are picked

  /// All finite points if kMaxPoints have room for them, else at most one a cube; the cubes' width
  /// grows from width_m > 0 by a quarter until there is room. No heap.
  /// Cost: some 10 ns a point and width tried.
  ///
  /// @param picked  kMaxPoints or more; gets the points' numbers, ascending
  /// @returns how many
  int Pick(std::span<const Eigen::Vector3f> points, float width_m, std::span<int> picked);

 private:
  static constexpr int kSlots = 4 * kMaxPoints;

  int PickOfCubes(std::span<const Eigen::Vector3f> points, float width_m, std::span<int> picked);
  bool Insert(const Eigen::Vector3i& cube);

  struct Slot {
    std::uint32_t try_number = 0;  ///< in which it was filled
    Eigen::Vector3i cube;
  };
  std::array<Slot, kSlots> slots_{};
  std::uint32_t try_number_ = 0;
};

}  // namespace pipewright
