// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "plan/gain/surface.h"
#include "platform/core/fixed_vector.h"
#include "platform/core/frames.h"
#include "platform/core/rng.h"

namespace pipewright {

class VoxelGrid;

/// The sensors as the planner believes them, and the weight between their tasks.
/// [CFNBV] Bettles et al.: Coverage First Next Best View; its equation numbers are used below.
struct GainConfig {
  double fov_x_rad = 1.0471975511965976;  ///< 60 deg, along x_S
  double fov_y_rad = 0.7853981633974483;  ///< 45 deg, along y_S
  double range_m = 3.0;
  /// A surface nearer than this gives no reading, so its ray tells nothing; 0 is the paper's.
  double range_min_m = 0;
  double probe_radius_m = 0.4;
  double beta = 0.75;  ///< (23): share of the visual gain
  int rays = 200;      ///< per sensor, at most RaySet::kMaxRays
  /// Count solid voxels (VoxelGrid::SurfaceLeftAt) as surface even while they are free: those that
  /// a surface fills in part. Off: occupied ones alone, as published.
  bool solid_surfaces = false;
};

constexpr bool Valid(const GainConfig& c) {
  return c.fov_x_rad > 0 && c.fov_x_rad < 3 && c.fov_y_rad > 0 && c.fov_y_rad < 3 &&
         c.range_m > 0 && c.range_min_m >= 0 && c.range_min_m < c.range_m && c.probe_radius_m > 0 &&
         0 <= c.beta && c.beta <= 1 && 0 < c.rays && c.rays <= 512;
}

/// Where both sensors are. The two centres are the same point in the paper.
struct Viewpoint {
  Isometry3d X_WS = Isometry3d::Identity();
  Vector3d p_WP = Vector3d::Zero();
};

/// The viewpoint with its camera at p_WS looking along z_WS (|z| = 1), probe centre at p_WS.
/// Law (3) leaves the roll about z free; here the image is upright: x_S is horizontal, y_S points
/// down as far as it can. Looking straight up or down, x_S is -y_W.
Viewpoint UprightViewpoint(const Vector3d& p_WS, const Vector3d& z_WS);

/// Unit directions, in S for a camera, in any frame for the probe's sphere.
struct RaySet {
  static constexpr int kMaxRays = 512;
  FixedVector<Vector3d, kMaxRays> directions;
};

/// `config.rays` directions, uniform on the image plane within the field of view.
RaySet RandomCameraRays(const GainConfig& config, Rng& rng);
/// The same count on a regular lattice of the image, the same at each call: two candidates then
/// differ by what they see, not by their draws.
RaySet LatticeCameraRays(const GainConfig& config);
/// `config.rays` directions, uniform on the sphere.
RaySet RandomSphereRays(const GainConfig& config, Rng& rng);

/// How often a voxel counts that several rays of one viewpoint pass.
enum class GainCount : std::uint8_t {
  kPerRay,    ///< once a ray: (17) and (21) as printed
  kDistinct,  ///< once a viewpoint
};

/// What a viewpoint is expected to tell.
struct ViewGain {
  double visual_nats = 0;    ///< (17)
  double coverage_nats = 0;  ///< (21) with the sign of (22) corrected: ln 2 a voxel
  int unknown_voxels = 0;    ///< counted in visual_nats (per ray: with repetition)
  int uncovered_voxels = 0;  ///< counted in coverage_nats (likewise)
};

/// (23): beta G_v + (1 - beta) G_c, nats.
constexpr double WeightedGain(const GainConfig& config, const ViewGain& gain) {
  return config.beta * gain.visual_nats + (1 - config.beta) * gain.coverage_nats;
}

/// The gains of viewpoints over one state of the map.
///
/// Update() takes a dense copy of the map's box; the rays then walk that copy. A ray passes the
/// voxels whose half-open boxes its segment crosses, from the one that holds its origin on. It ends
/// with the first occupied voxel (which it still counts), at its range, or where it leaves W; it
/// may start outside W, and only voxels within W count. Unknown voxels are passed, and count I_o =
/// ln 2 (18) unless they are residual.
///
/// All memory is taken at construction: see MemoryBytes().
class GainEvaluator {
 public:
  GainEvaluator(const GainConfig& config, const MapConfig& map);
  ~GainEvaluator();
  GainEvaluator(const GainEvaluator&) = delete;
  GainEvaluator& operator=(const GainEvaluator&) = delete;

  const GainConfig& config() const { return config_; }

  /// Copies the state of `map`, which must have the configuration given at construction. Voxels of
  /// W with ignored[WorkspaceIndex] != 0 are not counted and not listed; empty: none.
  void Update(const VoxelGrid& map, std::span<const std::uint8_t> ignored = {});

  /// Surface to be covered beside the map's own: the voxels of these patches count as uncovered
  /// from where a patch is met (see SurfaceMet). Until the next Update(); the patches must outlive
  /// it.
  void SetSurface(std::span<const SurfacePatch> patches);

  /// Whether a probe at p_WP meets the patch: within its radius, on the side that the patch faces,
  /// with no occupied voxel in sight's way but within 1.5 voxels of the patch.
  bool SurfaceMet(const Vector3d& p_WP, const SurfacePatch& patch) const;

  /// Unknown, counted voxels of W that share a face with a free one, and uncovered ones; z slowest.
  std::span<const VoxelIndex> Frontier() const;
  std::span<const VoxelIndex> Uncovered() const;
  /// Unknown, counted voxels of W.
  std::span<const VoxelIndex> Unknown() const;

  /// Visual gain (17) over `camera` (turned by X_WS) and coverage gain (21) over `probe`, from
  /// p_WP. An origin outside the stored box, or not finite, gains nothing. Cost: a few ns a voxel
  /// passed.
  ViewGain Evaluate(const Viewpoint& view, const RaySet& camera, const RaySet& probe,
                    GainCount count);

  /// Visual gain over `camera`, distinct; the coverage gain counts every uncovered voxel whose
  /// centre lies within the probe's radius of p_WP and that is in sight of it as
  /// VoxelGrid::MarkCovered has it, and every voxel of which a surface patch is met. Deterministic.
  ViewGain EvaluateExact(const Viewpoint& view, const RaySet& camera);

  /// The same for a sequence of views, each counting only what the others before it do not: what a
  /// way gains, sample by sample. BeginWay() forgets the sequence.
  void BeginWay();
  ViewGain NextOnWay(const Viewpoint& view, const RaySet& camera);
  ViewGain NextOnWay(const Vector3d& p_WP);  ///< coverage alone

  /// Unknown voxels of the stored box outside W that `camera` passes within range_m: no gain, but
  /// room for the robot to move once they are known. Distinct.
  int RoomCount(const Isometry3d& X_WS, const RaySet& camera, double range_m);

  /// Evaluate() of many.
  void EvaluateAll(std::span<const Viewpoint> views, const RaySet& camera, const RaySet& probe,
                   GainCount how, std::span<ViewGain> gains);

  /// Adds 1 (up to 255) to tally[WorkspaceIndex] of every voxel that EvaluateExact() counts.
  void Tally(const Viewpoint& view, const RaySet& camera, std::span<std::uint8_t> tally);
  /// The same on a way: of every voxel that NextOnWay() counts.
  void TallyOnWay(const Viewpoint& view, const RaySet& camera, std::span<std::uint8_t> tally);

  /// Whether the voxel can be seen from p_W as VoxelGrid::MarkCovered has it, at any distance.
  bool InSight(const Vector3d& p_W, const VoxelIndex& target) const;

  /// Place of a voxel of W in a dense array of W's voxels, x fastest.
  int WorkspaceIndex(const VoxelIndex& v) const;
  int workspace_voxels() const;

  std::size_t MemoryBytes() const;

 private:
  struct Cells;

  void CollectLists();
  int CountUnknown(const Isometry3d& X_WS, const RaySet& camera, GainCount count);
  template <typename Found>
  void SearchUncovered(const Vector3d& p_WP, Found found);

  GainConfig config_;
  std::unique_ptr<Cells> cells_;
};

}  // namespace pipewright
