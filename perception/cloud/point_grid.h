// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

namespace pipewright {

/// Points by the cube that holds them, for neighbours within the cube's width. Cubes share slots of
/// a fixed table by a hash: a neighbour is asked for its distance, so that sharing costs time only.
/// ~0.5 MB, no heap.
class PointGrid {
 public:
  static constexpr int kMaxPoints = 1 << 15;

  /// The points must stay where they are. At most kMaxPoints.
  void Set(std::span<const Eigen::Vector3f> points, float width_m);

  /// Calls visit(index) for the points within the width of p, each once. Cost: O(points in the 27
  /// cubes about p).
  template <typename Visit>
  void ForEachNear(const Eigen::Vector3f& p, const Visit& visit) const {
    ForEachSlotNear(p, [&](int slot) {
      for (int i = first_[slot]; i < end_[slot]; ++i) {
        if (IsNear(order_[i], p)) {
          visit(order_[i]);
        }
      }
    });
  }

  /// The same, and points for which take(index) is true leave the grid: where many are near each
  /// other, later questions then meet few.
  template <typename Take>
  void TakeNear(const Eigen::Vector3f& p, const Take& take) {
    ForEachSlotNear(p, [&](int slot) {
      for (int i = first_[slot]; i < end_[slot];) {
        if (IsNear(order_[i], p) && take(order_[i])) {
          order_[i] = order_[--end_[slot]];
        } else {
          ++i;
        }
      }
    });
  }

 private:
  static constexpr int kSlots = 1 << 15;

  /// The slots of the 27 cubes about p, each once.
  template <typename Visit>
  void ForEachSlotNear(const Eigen::Vector3f& p, const Visit& visit) const {
    std::array<int, 27> seen{};
    int slots = 0;
    const Eigen::Vector3i cell = CellOf(p);
    for (int k = 0; k < 27; ++k) {
      const int slot = SlotOf(cell + Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
      bool again = false;
      for (int j = 0; j < slots; ++j) {
        again |= seen[j] == slot;
      }
      if (!again) {
        seen[slots++] = slot;
        visit(slot);
      }
    }
  }

  bool IsNear(int i, const Eigen::Vector3f& p) const {
    return (points_[i] - p).squaredNorm() <= width_m_ * width_m_;
  }
  Eigen::Vector3i CellOf(const Eigen::Vector3f& p) const {
    return (p / width_m_).array().floor().cast<int>();
  }
  static int SlotOf(const Eigen::Vector3i& cell) {
    const auto mix = static_cast<std::uint32_t>(cell.x()) * 0x9E3779B1U ^
                     static_cast<std::uint32_t>(cell.y()) * 0x85EBCA77U ^
                     static_cast<std::uint32_t>(cell.z()) * 0xC2B2AE3DU;
    return static_cast<int>((mix ^ mix >> 15) % kSlots);
  }

  std::span<const Eigen::Vector3f> points_;
  float width_m_ = 1;
  // Slot k holds order_[first_[k]] ... order_[end_[k] - 1].
  std::array<int, kSlots> first_{};
  std::array<int, kSlots> end_{};
  std::array<int, kMaxPoints> order_{};
};

}  // namespace pipewright
