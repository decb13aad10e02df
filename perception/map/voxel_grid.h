// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>
#include <cmath>
#include <cstdint>
#include <vector>

#include "perception/map/brick_voxels.h"
#include "perception/map/scan_window.h"
#include "perception/map/voxel_index.h"

namespace pipewright {

/// How many voxels of the workspace W are what. total = free + occupied + unknown + residual.
struct MapCounts {
  int total = 0;
  int free = 0;
  int occupied = 0;
  int unknown = 0;   ///< not known, and not given up
  int residual = 0;  ///< not known, and no valid viewpoint can see it
  int covered = 0;   ///< of the occupied ones
};

/// What one scan did to the map.
struct ScanStats {
  int points = 0;
  int rejected = 0;  ///< not finite, or farther than OctoMap's keys reach: no effect
  int hits = 0;      ///< voxels of the box that got a hit
  int misses = 0;    ///< voxels of the box that got a miss
  int refused = 0;   ///< voxels that were not updated for want of a brick
};

/// Where a ray ended.
struct RayHit {
  bool hit = false;  ///< at an occupied voxel
  VoxelIndex end;    ///< that voxel, or the last one looked at
};

/// What a segment passed.
struct SegmentTrace {
  int unknown = 0;   ///< unknown voxels before its end
  bool hit = false;  ///< it ended at an occupied voxel
  VoxelIndex end;    ///< that voxel
};

/// What a brick stores of a voxel. As int16, in units of 1/4096, a map takes little more than half
/// the memory; its log-odds are then off by at most half a unit for each scan that saw the voxel.
#if defined(PIPEWRIGHT_MAP_INT16)
using StoredLogOdds = std::int16_t;
inline constexpr float kLogOddsUnit = 1.0F / 4096;
#else
using StoredLogOdds = float;
inline constexpr float kLogOddsUnit = 1;
#endif

/// Occupancy of a box of voxels, by OctoMap's rules, on memory that is fixed at construction.
///
/// Log-odds lie in bricks of 8x8x8 out of a pool; a dense table over the box says which brick is
/// where. Four bits of every voxel of the box lie in flat planes, x fastest, so that a ray steps by
/// adding a stride: known, occupied (or swept, while unknown), probed (or residual, while unknown)
/// and solid. What a full pool refuses is counted; what it holds is kept.
///
/// Counts and entropies speak of the workspace W, exactly; counts are kept up with each change.
class VoxelGrid {
 public:
  /// Allocates everything; `config` must be Valid.
  explicit VoxelGrid(const MapConfig& config);

  /// Integrates a scan as OctoMap 1.9.7's insertPointCloud does, not lazy, not discretised: every
  /// voxel passed gets a miss and every end point's voxel a hit, once a scan, hits before misses;
  /// a point farther than max_range_m (negative: none) gives misses up to there. Voxels outside the
  /// box are skipped, inside it states and log-odds are OctoMap's. Two points closer than 1e-18 m
  /// to the origin are as at the origin. O(points x voxels passed); no heap.
  ScanStats InsertScan(const Vector3f* points_W, int count, const Vector3f& origin_W,
                       double max_range_m);

  /// The same with discretize = true: one ray for each voxel that holds points, to its centre.
  ScanStats InsertScanDiscretized(const Vector3f* points_W, int count, const Vector3f& origin_W,
                                  double max_range_m);

  /// Outside the box every voxel is unknown, not swept, not covered, with log-odds 0.
  VoxelState State(const VoxelIndex& v) const;
  float LogOdds(const VoxelIndex& v) const;
  bool Covered(const VoxelIndex& v) const;
  bool Swept(const VoxelIndex& v) const;  ///< and still unknown
  bool Residual(const VoxelIndex& v) const;
  /// What motion must not touch: occupied, or unknown and not swept, or solid: once hit more than
  /// its misses outweighed. A voxel that a surface fills in part is hit from one side and passed
  /// from another, and by occupancy alone would come and go; the surface does not.
  bool Obstacle(const VoxelIndex& v) const;

  /// Takes a voxel over from a stored map: known from now on, log-odds clamped. False: outside the
  /// box, not finite, or no brick.
  bool Restore(const VoxelIndex& v, float log_odds);

  /// The robot's own body is or was here: unknown voxels whose box meets the ball are no obstacle.
  void MarkSweptSphere(const Vector3d& center_W, double radius_m);

  /// The probe is at P: known voxels of W whose centre is within the radius and that are in line
  /// of sight are probed, but for those in the open. In line of sight: their centre, or the middle
  /// of a face turned to P, with no occupied voxel on the way (for a free voxel: no unknown one
  /// either). An occupied voxel that was probed is covered; one that turns free no longer is.
  ///
  /// In the open: free, with nothing but free voxels around it, 26 of the box. No surface is there,
  /// for behind one lies a voxel that is not free. What comes to be in the open is probed no
  /// longer: what appears there later is new. A free voxel that is not in the open stays probed,
  /// and is covered again when it turns back: a surface that fills it in part is hit from one side
  /// and passed from another, and the voxel comes and goes. (So do those that are left of a thing
  /// taken away where it touched another: there the next one is taken for covered.) Log-odds do not
  /// tell the two apart: of the voxels that a mission among pipes covers, a quarter go down to the
  /// lower clamp and turn occupied again, but one in 400 after it was in the open; under faults,
  /// one in 120.
  /// @returns how many occupied voxels are newly covered
  int MarkCovered(const Vector3d& p_WP, double radius_m);

  /// Only an unknown voxel can be residual; it ceases to be when it becomes known.
  void SetResidual(const VoxelIndex& v, bool residual);

  const MapCounts& counts() const { return counts_; }

  /// Mean over W of I_o = -p ln p - (1 - p) ln(1 - p), (18): ln 2 for a voxel that is not known,
  /// its own entropy (at most 1e-7 off, by table) for one that is. Nats per voxel. O(voxels in
  /// bricks), a few ns each.
  double visual_entropy() const;
  /// Mean over W of I_c, (22) with the sign mended: ln 2 for occupied and not covered, else 0.
  double coverage_entropy() const;
  /// S = 1/|W| sum (I_o + I_c).
  double combined_entropy() const { return visual_entropy() + coverage_entropy(); }

  /// OctoMap's castRay: from the origin's voxel along the direction (any length > 0) to the first
  /// occupied voxel. Without ignore_unknown an unknown voxel ends it, without a hit. max_range_m
  /// counts to voxel centres, <= 0: none. Outside the box all is unknown. The numbers are taken in
  /// float, as OctoMap's are.
  RayHit CastRay(const Vector3d& origin_W, const Vector3d& direction_W, double max_range_m,
                 bool ignore_unknown) const;

  /// The same for many directions from one origin: hits[i] is that of directions_W[i].
  void CastRays(const Vector3f& origin_W, const Vector3f* directions_W, int count,
                double max_range_m, bool ignore_unknown, RayHit* hits) const;

  /// Each segment from the origin to ends_W[i]: along the voxels of OctoMap's computeRayKeys (see
  /// RayWalk), until the first occupied one, the end's voxel or the end of the box. Nothing is
  /// passed from an origin outside the box.
  void TraceSegments(const Vector3f& origin_W, const Vector3f* ends_W, int count,
                     SegmentTrace* traces) const;

  /// Moves the box, and W with it, by whole bricks; config() is then of where it is. What stays in
  /// it keeps all that is known; voxels that enter are unknown; a brick that leaves is first handed
  /// to leave(const BrickVoxels&), to be written out, and is free again. Should it come back,
  /// Restore() takes its voxels, as known and with the log-odds they had; what was swept, probed or
  /// solid is forgotten. For a box of WholeBricks. O(voxels) bits are moved; no heap.
  template <typename Leave>
  void Move(const VoxelIndex& bricks, Leave leave);
  /// The move that brings the box's middle nearest to P, to follow a robot; within OctoMap's keys.
  /// None for what is not finite.
  VoxelIndex BricksTo(const Vector3d& p_W) const;

  const MapConfig& config() const { return config_; }
  VoxelIndex VoxelOf(const Vector3d& p_W) const;
  Vector3d Center(const VoxelIndex& v) const;
  bool InBox(const VoxelIndex& v) const { return Within(v, config_.lo, config_.hi); }
  bool InWorkspace(const VoxelIndex& v) const {
    return Within(v, config_.workspace_lo, config_.workspace_hi);
  }

  /// Voxels of the box and their flat index, x fastest: for stamps, queues and inner loops.
  int voxel_count() const { return nx_ * ny_ * nz_; }
  int IndexOf(const VoxelIndex& v) const { return static_cast<int>(FlatIndex(v)); }
  VoxelIndex VoxelAt(int index) const;
  bool KnownAt(int index) const { return (Code(index) & kKnown) != 0; }
  bool OccupiedAt(int index) const { return Code(index) == kOccupiedCode; }
  bool ObstacleAt(int index) const {
    return Code(index) == 0 || Code(index) == kOccupiedCode || SolidAt(index);
  }
  /// Occupied or solid, and not probed: a surface that is left to cover, even where the map takes
  /// its voxel for free at the moment, unless in the open.
  bool SurfaceLeftAt(int index) const {
    return !Flag(index) &&
           (OccupiedAt(index) || (SolidAt(index) && KnownAt(index) && !InTheOpen(VoxelAt(index))));
  }
  bool CoveredAt(int index) const { return OccupiedAt(index) && Flag(index); }

  /// Changes whenever a voxel's State, Swept or Obstacle does.
  std::uint64_t revision() const { return revision_; }
  /// The box in blocks of 8x8x8 voxels, whether or not there is a brick: how many, the voxels of
  /// one that are in the box, and what revision() was when one of them last changed.
  int block_count() const { return static_cast<int>(block_revisions_.size()); }
  VoxelBox BlockBox(int block) const;
  std::uint64_t BlockRevision(int block) const { return block_revisions_[block]; }
  int bricks_used() const { return static_cast<int>(bricks_.size()) - bricks_free_; }
  /// Voxel updates that a full pool has refused so far.
  std::int64_t updates_refused() const { return updates_refused_; }

  static constexpr int kBrickVoxels = 512;
  /// Voxels that one discretised scan can end in; what is beyond is counted as rejected.
  static constexpr int kDiscretizedEnds = 1 << 16;
  /// Per voxel of an allocated brick: its log-odds and its four bits.
  static constexpr double kBytesPerVoxel = sizeof(StoredLogOdds) + 4.0 / 8;
  /// All heap of one grid, in bytes.
  std::int64_t MemoryBytes() const;

 private:
  friend class ScanInserter;
  friend class RayCaster;
  friend class RayWalk;

  // A voxel's two state bits: 0 unknown, 1 unknown and swept, 2 free, 3 occupied.
  static constexpr unsigned kSweptCode = 1;
  static constexpr unsigned kKnown = 2;
  static constexpr unsigned kOccupiedCode = 3;

  struct Brick {
    StoredLogOdds log_odds[kBrickVoxels];
  };

  // Also of voxels outside the box, where it means nothing but can be stepped from.
  std::int64_t FlatIndex(const VoxelIndex& v) const {
    return (v.x - config_.lo.x) +
           nx_ * ((v.y - config_.lo.y) + std::int64_t{ny_} * (v.z - config_.lo.z));
  }
  unsigned Code(int i) const { return (codes_[i >> 4] >> ((i & 15) * 2)) & 3U; }
  void SetCode(int i, unsigned code) {
    std::uint32_t& word = codes_[i >> 4];
    const int shift = (i & 15) * 2;
    word = (word & ~(3U << shift)) | (code << shift);
  }
  bool SolidAt(int i) const { return ((solid_[i >> 6] >> (i & 63)) & 1U) != 0; }
  bool Flag(int i) const { return ((flags_[i >> 6] >> (i & 63)) & 1U) != 0; }
  void SetFlag(int i, bool flag) {
    const std::uint64_t bit = std::uint64_t{1} << (i & 63);
    flags_[i >> 6] = flag ? flags_[i >> 6] | bit : flags_[i >> 6] & ~bit;
  }

  int BrickOf(const VoxelIndex& v) const;  // where top_ tells of v's brick
  static int CellInBrick(const VoxelIndex& v) {
    return (v.x & 7) | ((v.y & 7) << 3) | ((v.z & 7) << 6);
  }
  void Touch(int block) { block_revisions_[block] = ++revision_; }
  StoredLogOdds* LogOddsSlot(const VoxelIndex& v);
  bool Sees(const Vector3d& p_WP, double radius_m, const VoxelIndex& v) const;
  bool Sees(const Vector3d& p_WP, const Vector3d& p_WQ, const VoxelIndex& v) const;
  void UpdateRow(const VoxelIndex& v, std::uint32_t hits, std::uint32_t misses, ScanStats* stats);
  void Become(int index, const VoxelIndex& v, bool occupied);
  bool InTheOpen(const VoxelIndex& v) const;
  void SetProbed(int index, const VoxelIndex& v);
  void ForgetProbedInTheOpen(const VoxelIndex& around);
  void CountChange(unsigned from, unsigned to, bool flag);
  void MarkSolid(int index, StoredLogOdds log_odds) {
    if (log_odds >= solid_from_) {  // occupied, so an obstacle already: no new revision
      solid_[index >> 6] |= std::uint64_t{1} << (index & 63);
    }
  }
  BrickVoxels VoxelsOf(int block) const;
  void Release(int block);
  void Shift(const VoxelIndex& bricks);
  void Recount();
  void TabulateEntropy();
  std::int64_t EntropyUnits(StoredLogOdds log_odds) const;

  MapConfig config_;
  int nx_ = 0;
  int ny_ = 0;
  int nz_ = 0;
  StoredLogOdds hit_ = 0;  // rounded as OctoMap rounds them
  StoredLogOdds miss_ = 0;
  StoredLogOdds min_ = 0;
  StoredLogOdds max_ = 0;
  StoredLogOdds threshold_ = 0;
  StoredLogOdds solid_from_ = 0;
  int bricks_x_ = 0;
  int bricks_y_ = 0;
  int bricks_free_ = 0;
  std::int64_t updates_refused_ = 0;
  std::uint64_t revision_ = 1;
  MapCounts counts_;
  std::vector<std::int32_t> top_;  // brick of each 8x8x8 block of the box, -1: none
  std::vector<std::uint64_t> block_revisions_;
  std::vector<std::uint8_t> probed_near_;  // of each block; 0: none of it is beside a probed one
  std::vector<Brick> bricks_;
  std::vector<std::int32_t> free_bricks_;  // the first bricks_free_; the last of them goes next
  std::vector<std::uint32_t> codes_;       // two bits a voxel
  std::vector<std::uint64_t> flags_;       // probed when known, residual when unknown
  std::vector<std::uint64_t> solid_;       // was hit often enough to be an obstacle for good
  ScanWindow window_;                      // scratch of a scan: what it hits and passes
  std::vector<std::int32_t> ends_;         // scratch of a discretised scan: points, one a voxel
  std::vector<std::int64_t> entropy_table_;
};

template <typename Leave>
void VoxelGrid::Move(const VoxelIndex& bricks, Leave leave) {
  assert(WholeBricks(config_));
  const VoxelIndex by{8 * bricks.x, 8 * bricks.y, 8 * bricks.z};
  for (int block = 0; block < block_count(); ++block) {
    const VoxelIndex lo = BlockBox(block).lo;
    if (top_[block] >= 0 && !InBox({lo.x - by.x, lo.y - by.y, lo.z - by.z})) {
      leave(VoxelsOf(block));
      Release(block);
    }
  }
  Shift(bricks);
}

}  // namespace pipewright
