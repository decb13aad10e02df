// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "perception/localization/placement.h"
#include "platform/core/fixed_vector.h"
#include "platform/core/frames.h"
#include "platform/core/status.h"

namespace pipewright {

struct SurfelMapConfig {
  double cell_m = 0.05;
  int count_min = 8;      ///< points of a cell before a surfel is fitted
  int count_max = 64;     ///< points after which the cell takes no more: the reference stands
  double bend = 0.04;     ///< of cell_m: how far a surface may depart from its plane
  double spread = 0.4;    ///< of cell_m: least standard deviation of the points along the surface
  double tilt_rad = .05;  ///< largest standard deviation of the normal
};

constexpr bool Valid(const SurfelMapConfig& c) {
  return c.cell_m > 0 && c.count_min >= 3 && c.count_max >= c.count_min && c.bend > 0 &&
         c.spread > 0 && c.tilt_rad > 0;
}

/// A piece of a surface: n'x = n'p in W. n points to the side it was seen from.
struct Surfel {
  Vector3d p_W = Vector3d::Zero();
  Vector3d n_W = Vector3d::UnitZ();
  double offset_var_m2 = 0;  ///< of n'p
  double rough_var_m2 = 0;   ///< of the surface about it: what noise does not explain
  double tilt_var_rad2 = 0;  ///< of n, each way
  Placement placed;          ///< the mean of its points'
};

/// Surfaces as surfels in a hash of cubic cells: what scans are registered to.
///
/// Each cell sums the moments of its points, weighted by their information w = 1/σ²:
///
///   W = Σ w,   m = Σ w x / W,   S = Σ w (x - m)(x - m)' / W = Σ λ_i v_i v_i',  λ_0 <= λ_1 <= λ_2
///
/// A surfel is fitted to the moments of a cell and its 26 neighbours together, so that a wall on
/// the border of two cells is not torn in two. It holds when the points spread along the surface
/// (λ_1), when noise explains what is across (λ_0), and when the normal is known well enough:
///
///   p = m,  n = v_0,   σ²(n'p) = λ_0/N,   σ²(n) = λ_0/(N λ_1),   rough² = λ_0 - noise²
///
/// It is fitted anew each time the cell's count doubles. At count_max the cell is frozen: later
/// scans are measured against it and do not move it, so that the reference cannot creep. A point
/// whose placement is far better than its cell's (kBetter) begins the cell anew; a neighbour that
/// is so much worse has no part in a fit.
///
/// ~11.5 MB, no heap. Full is an answer: new cells are refused and counted, those held stay.
class SurfelMap {
 public:
  static constexpr int kSlots = 1 << 16;
  static constexpr int kMaxCells = kSlots / 4 * 3;

  explicit SurfelMap(const SurfelMapConfig& config = {});

  void Clear();

  /// A point of a surface, seen from p_WS with this standard deviation. O(1); with a fit, 27
  /// look-ups. kOutOfRange: not finite, or beyond 10^5 cells. kFull: no room for its cell.
  Status Add(const Vector3d& p_WQ, double sigma_m, const Vector3d& p_WS,
             const Placement& placed = {});

  /// The cell whose surfel Find() gives there is as one that nobody has seen.
  void Forget(const Vector3d& p_WQ);

  /// The surfel of the point's cell, else the nearest of the six cells beside it; null: none.
  const Surfel* Find(const Vector3d& p_WQ) const;
  /// How far beside a surface its surfels are found on either side of it; farther, perhaps on one.
  /// Points on that side alone would pull.
  double reach_m() const { return config_.cell_m; }

  /// Points seen in the point's cell and the six beside it that no surfel stands for: those of an
  /// edge, of something bent, or of what was seen thinly. 0 where the cell itself has a surfel.
  int Loose(const Vector3d& p_WQ) const;

  int cells() const { return cells_; }
  std::uint64_t refused() const { return refused_; }

 private:
  using Key = std::array<int, 3>;

  /// Moments about the cell's centre, in cells.
  struct Moments {
    double w = 0;
    Vector3d wx = Vector3d::Zero();
    std::array<double, 6> wxx{};  ///< xx xy xz yy yz zz
    double w_placed_m2 = 0;
    double w_placed_rad2 = 0;
    int count = 0;

    Placement placed() const { return {w_placed_m2 / w, w_placed_rad2 / w}; }
  };
  struct Cell {
    Key key{};
    bool used = false;
    bool has_surfel = false;
    Moments moments;
    Surfel surfel;
  };

  bool KeyOf(const Vector3d& p_WQ, Key& key) const;
  int Slot(const Key& key) const;
  const Cell* At(const Key& key) const;
  const Cell* FindCell(const Vector3d& p_WQ) const;
  template <typename Visit>
  void ForEachBeside(const Key& key, const Visit& visit) const;
  void Fit(Cell& cell, const Vector3d& p_WS) const;
  Moments Block(const Cell& center) const;

  SurfelMapConfig config_;
  std::array<Cell, kSlots> slots_{};
  int cells_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace pipewright
