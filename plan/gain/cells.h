// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "perception/map/fan_kernels.h"
#include "perception/map/voxel_grid.h"
#include "plan/gain/gain.h"

namespace pipewright {

/// The evaluator's dense copy of the map, one byte a voxel, with a border one cell wide, so that a
/// walk needs no bounds check but the flag's; and two bits a voxel for each thing that rays look
/// for, which they walk side by side. The walk of one ray is what defines where it goes; it does
/// the rays for which the other cannot be sure.
struct GainEvaluator::Cells {
  enum Flag : std::uint8_t {
    kInWorkspace = 1,
    kUnknown = 2,    ///< in W, counted
    kOccupied = 4,   ///< a surface, in W or not
    kUncovered = 8,  ///< in W, occupied, counted
    kBorder = 16,    ///< outside the stored box
    kFree = 32,
    kRoom = 64,      ///< unknown, outside W
    kIgnored = 128,  ///< in W, not counted
  };

  explicit Cells(const MapConfig& config);

  int Index(const VoxelIndex& v) const {
    return v.x - map.lo.x + 1 + nx * (v.y - map.lo.y + 1 + ny * (v.z - map.lo.z + 1));
  }

  /// In units of cells, measured from the corner of cell (0, 0, 0), which lies in the border.
  Vector3d InCells(const Vector3d& p_W) const {
    return p_W / map.width_m - Vector3d(map.lo.x - 1, map.lo.y - 1, map.lo.z - 1);
  }

  Vector3d CenterInCells(const VoxelIndex& v) const {
    return {v.x - map.lo.x + 1.5, v.y - map.lo.y + 1.5, v.z - map.lo.z + 1.5};
  }

  /// Also false when p is not finite.
  bool InBox(const Vector3d& p) const {
    return 1 <= p.x() && p.x() < nx - 1 && 1 <= p.y() && p.y() < ny - 1 && 1 <= p.z() &&
           p.z() < nz - 1;
  }

  /// Calls visit(cell) for each cell that the segment {origin + t direction, 0 <= t <= length}
  /// crosses, in order, until it returns false. Amanatides, Woo: A fast voxel traversal algorithm
  /// for ray tracing, 1987. All in cells; the origin in the box; visit stops at the border.
  template <typename Visit>
  void Walk(const Vector3d& origin, const Vector3d& direction, double length, Visit visit) const;

  /// Whether a surface lies on the ray before `length`.
  bool Blocked(const Vector3d& origin, const Vector3d& direction, double length) const;

  /// Calls found(cell) for the cells with flag `wanted` that the ray passes, up to and with the
  /// first surface, up to where it leaves W (which is convex: it does not come back), for room up
  /// to where it leaves the box.
  template <typename Found>
  void Search(const Vector3d& origin, const Vector3d& direction, double length, Flag wanted,
              Found found) const;

  /// Fills `directions` with the rays, turned by X_WS. @returns how many
  int Turn(const Isometry3d& X_WS, const RaySet& rays);

  /// Search() of the first n `directions`. Each wanted cell once between two Forget() goes to the
  /// end of `taken`. @returns how often wanted cells were passed, or how many went there
  int Gather(const Vector3d& origin, int n, double length, Flag wanted, GainCount count);

  /// Drops those of the first n `directions` that meet a surface before `length`. @returns how many
  /// are left
  int DropBlocked(const Vector3d& origin, int n, double length);

  /// Whether the probe sees the voxel from `origin` as VoxelGrid::MarkCovered has it: its centre or
  /// the middle of a face that is turned to the origin, with no occupied voxel on the way, and for
  /// a voxel that is not occupied no unknown one either. Swept voxels count as unknown here.
  bool Seen(const Vector3d& origin, const VoxelIndex& v) const;

  /// Whether the segment {origin + t way, 0 <= t <= 1} meets `target` before a surface or, unless
  /// through_unknown, before an unknown cell.
  bool Meets(const Vector3d& origin, const Vector3d& way, int target, bool through_unknown) const;

  /// Makes `taken` empty, takes its marks away and makes a stamp that no cell bears.
  void Forget();

  /// Takes a cell into `taken`, once.
  void Take(int cell);

  /// What the rays look for, as the codes of fan::Search, from the flags.
  void LayPlanes();
  std::vector<std::uint32_t>& PlaneOf(Flag wanted) {
    return planes[wanted == kUnknown ? 0 : wanted == kUncovered ? 1 : 2];
  }

  MapConfig map;
  int nx;
  int ny;
  int nz;
  int workspace_voxels;
  std::vector<std::uint8_t> flags;
  std::array<std::vector<std::uint32_t>, 3> planes;
  std::vector<std::uint32_t> marks;  ///< a bit for each cell in `taken`
  std::vector<std::int32_t> taken;   ///< cells, each once; the first taken_count
  int taken_count = 0;
  std::vector<std::uint32_t> probe_stamps;    ///< of what the probe covers: a voxel may be both
  std::vector<std::int32_t> workspace_index;  ///< of a cell; -1 outside W
  std::uint32_t stamp = 0;
  std::vector<VoxelIndex> unknown;
  std::vector<VoxelIndex> frontier;
  std::vector<VoxelIndex> uncovered;
  std::span<const SurfacePatch> surface;
  std::array<Vector3d, RaySet::kMaxRays> directions;  ///< scratch: rays of one origin

 private:
  fan::CellOrigin AimFrom(const Vector3d& origin, bool within_workspace) const;
};

template <typename Visit>
void GainEvaluator::Cells::Walk(const Vector3d& origin, const Vector3d& direction, double length,
                                Visit visit) const {
  const std::array<int, 3> stride{1, nx, nx * ny};
  std::array<int, 3> step{};
  std::array<double, 3> t_next{};
  std::array<double, 3> t_cell{};
  int cell = 0;
  for (int i = 0; i < 3; ++i) {
    const double floor = std::floor(origin[i]);
    cell += static_cast<int>(floor) * stride[i];
    const double d = direction[i];
    const bool moves = d != 0;
    step[i] = d > 0 ? stride[i] : -stride[i];
    t_cell[i] = moves ? std::abs(1 / d) : 0;
    t_next[i] = moves ? ((d > 0 ? floor + 1 : floor) - origin[i]) / d
                      : std::numeric_limits<double>::infinity();
  }
  while (visit(cell)) {
    const int xy = t_next[0] < t_next[1] ? 0 : 1;
    const int axis = t_next[xy] < t_next[2] ? xy : 2;
    if (t_next[axis] > length) {
      return;
    }
    cell += step[axis];
    t_next[axis] += t_cell[axis];
  }
}

template <typename Found>
void GainEvaluator::Cells::Search(const Vector3d& origin, const Vector3d& direction, double length,
                                  Flag wanted, Found found) const {
  const bool within = wanted != kRoom;
  bool entered = false;
  Walk(origin, direction, length, [&](int cell) {
    const std::uint8_t here = flags[cell];
    const bool inside = (here & kInWorkspace) != 0;
    if ((here & kBorder) != 0 || (within && entered && !inside)) {
      return false;
    }
    entered = inside;
    if ((here & wanted) != 0) {
      found(cell);
    }
    return (here & kOccupied) == 0;
  });
}

}  // namespace pipewright
