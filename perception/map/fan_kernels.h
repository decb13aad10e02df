// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

/// Rays of one origin, eight at a time, through the voxels of a box: the inner loops of inserting
/// scans, tracing segments and casting rays. Plain arrays in and out, no other header: this is
/// compiled once for every machine and once for x86-64 with AVX2, and chosen when the program runs.
///
/// OctoMap steps a ray by adding up crossings in double; which voxels it passes depends on the
/// order of those sums alone. Here a crossing is an int32 in units of 2^-29 of the ray's length,
/// off by no more than half a unit for each addition; so wherever two crossings lie farther apart
/// than all that can have added up, their order is OctoMap's, to the last bit of its arithmetic. A
/// ray with two nearer than that (about one in a hundred, but most of those from a border of
/// voxels) is followed once more, four at a time, in OctoMap's own double: there nothing is left
/// unsure.
namespace pipewright::fan {

/// What all rays of one origin share. The origin lies in voxel `voxel`, and that in the box.
struct Origin {
  float p_W[3];
  double width_m;
  double width_inv;
  int voxel[3];  ///< absolute
  double to_border_m[2]
                    [3];  ///< to the borders of the origin's voxel, downwards [0] and upwards [1]
  int to_wall[2][3];      ///< voxels between the origin's and the box's last, likewise
  int stride[3];          ///< of the flat index of what is read or marked
  int index;              ///< flat index of the origin's voxel
};

/// Where a ray ended, and what it saw on its way.
struct End {
  int unknown;    ///< voxels passed that are not known
  int off[3];     ///< the last voxel looked at, less the origin's
  bool surface;   ///< that voxel is occupied
  bool by_sight;  ///< ended by what that voxel is, not by the ray's length or the box
};

/// Clips n points (x, y, z each) at max_range_m (< 0: never) to the ends of their rays, as OctoMap
/// does. hit_index is the flat index of a point's voxel, or -1: clipped, or outside the box.
void Clip(const Origin& o, const float* points_W, int n, double max_range_m, float* ends_W,
          std::int32_t* hit_index);

/// hit_index as Clip gives it, nothing clipped.
void Cells(const Origin& o, const float* points_W, int n, std::int32_t* hit_index);

/// Sets the bit of every voxel of the segments to ends_W, as OctoMap's computeRayKeys gives them,
/// until the box is left. @returns how many are no segments, since their ends are beyond the keys
/// or within 1e-18 m; their numbers are in redo[], which has room for n.
int Mark(const Origin& o, const float* ends_W, int n, std::uint32_t* bits, int* redo);

/// Follows the segments until the first occupied voxel or the end of the box. `codes` has two bits
/// a voxel: 3 occupied, 2 free, else unknown. A segment within the origin's voxel sees nothing.
/// @returns how many are no segments, as Mark, or may be none from an occupied voxel; their numbers
/// are in redo[], which has room for n + 1.
int Trace(const Origin& o, const float* ends_W, int n, const std::uint32_t* codes, End* ends,
          int* redo);

/// Follows n directions (any length > 0) from beyond the origin's voxel until the first occupied
/// voxel, the end of the box or, to within two, sure_m; with unknown_ends also until the first
/// unknown voxel. @returns how many have no length; their numbers are in redo[], which has room for
/// n + 1.
int Cast(const Origin& o, const float* directions_W, int n, double sure_m, bool unknown_ends,
         const std::uint32_t* codes, End* ends, int* redo);

/// What rays of one origin share that are given in double and in cells: of a planner, not
/// OctoMap's.
struct CellOrigin {
  double to_border[2][3];  ///< cells to the borders of the origin's own, downwards [0], upwards [1]
  int to_wall[2][3];       ///< cells between the origin's and the last that counts, likewise
  int stride[3];           ///< of the flat index
  int index;               ///< flat index of the origin's cell
};

/// What rays look for, and what they found.
struct Search {
  const std::uint32_t* codes;  ///< two bits a cell: 0 wanted, 1 wanted and an end, 2 none, 3 an end
  std::uint32_t* marks;        ///< a bit a cell: has been found
  std::int32_t* found;         ///< flat indices of cells that had no mark, one each; room for all
  int found_count = 0;
  int wanted = 0;  ///< wanted cells passed, as often as they are
};

/// Follows the rays {origin + t d, 0 <= t <= length}, in cells: from the origin's cell to the one
/// where a ray ends by its length, by the code (that cell included) or at the wall, by the order of
/// its crossings in double. @returns how many were not done for sure; their numbers are in redo[],
/// which has room for n + 1. They are not in `wanted`; what they marked is right, but not all.
int Gather(const CellOrigin& o, const double* directions, int n, double length, Search* search,
           int* redo);

/// Whether each of those rays meets a cell of code 3. @returns how many cannot be told, as Gather.
int FindBlocked(const CellOrigin& o, const double* directions, int n, double length,
                const std::uint32_t* codes, std::uint8_t* blocked, int* redo);

/// For tests, while no other thread is here: leaves AVX2 be, or takes it up again where there is
/// any.
/// @returns whether it is used now
bool UseBaseline(bool baseline_only);

}  // namespace pipewright::fan
