// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>

#include "perception/map/voxel_index.h"
#include "plan/cfnbv/planner.h"
#include "plan/motion/motion_planner.h"
#include "platform/core/rng.h"

namespace pipewright {

struct CfnbvConfig {
  GainConfig gain{.range_min_m = 0.17, .solid_surfaces = true};
  MotionPlannerConfig motion;
  double overhead_s = 2;  ///< t0 of the score G_w / (t0 + t): what a view costs beside the motion
  /// Configurations proposed a round: random ones near the robot and anywhere, and aimed ones.
  int near_candidates = 150;
  int far_candidates = 200;  ///< free ones; of at most far_draws
  int far_draws = 4000;
  int unknown_candidates = 150;
  int uncovered_candidates = 250;
  int rounds = 24;  ///< of proposals in one step, at most
  int paths = 8;    ///< motion plans tried a round, at most
  /// With fewer reachable candidates than this in a round the robot is cramped: then unknown voxels
  /// outside W, within room_range_m, count too, at this share of a nat, at most room_goals times
  /// between two times that W's map grows.
  int cramped_candidates = 40;
  double room_share = 0.1;
  double room_range_m = 1.0;
  int stop_room = 40;  ///< a view of fewer such voxels is not worth the way
  int room_goals = 12;
  int stop_unknown = 4;    ///< a view of fewer unknown voxels than this, and
  int stop_uncovered = 2;  ///< of fewer uncovered ones than this, is not worth the way
  int surface_frames =
      5;                  ///< pipes seen in so many frames say where surface is, see SurfaceToCover
  int stop_tests = 3000;  ///< reachable views that must be below it in a row before kComplete
  int tries_per_voxel = 3;       ///< views of a voxel that may fail before it is given up
  int forget_voxels = 50;        ///< so much new knowledge, and what had no path is tried again
  double stall_radius_m = 0.15;  ///< views this near to one that stalled twice are not taken
  /// kComplete also asks that of W this share is known, and of its surface this share is covered;
  /// else what is left is called unreachable (kNoReachableView).
  double complete_known_share = 0.5;
  double complete_covered_share = 0.5;
};

constexpr bool Valid(const CfnbvConfig& c) {
  const int proposals =
      c.near_candidates + c.far_candidates + c.unknown_candidates + c.uncovered_candidates;
  return Valid(c.gain) && Valid(c.motion) && c.overhead_s > 0 && c.near_candidates >= 0 &&
         c.far_candidates >= 0 && c.far_draws >= c.far_candidates && c.unknown_candidates >= 0 &&
         c.uncovered_candidates >= 0 && 0 < proposals && proposals <= 1000 && c.rounds > 0 &&
         c.paths > 0 && c.stop_unknown > 0 && c.stop_uncovered > 0 && c.cramped_candidates >= 0 &&
         c.room_share >= 0 && c.room_range_m > 0 && c.stop_room > 0 && c.room_goals >= 0 &&
         c.stop_tests > 0 && 0 < c.tries_per_voxel && c.tries_per_voxel < 255 &&
         c.forget_voxels > 0 && c.stall_radius_m >= 0 && 0 <= c.complete_known_share &&
         c.complete_known_share <= 1 && 0 <= c.complete_covered_share &&
         c.complete_covered_share <= 1;
}

/// The default planner: coverage first next best view over configurations that the robot can reach.
///
/// Candidates are collision-free configurations: aimed at uncovered voxels and at unknown voxels of
/// the frontier (by inverse kinematics), random near the robot and anywhere, and the best that were
/// left over. Each is scored by its distinct gain (23) over the least time that going there can
/// take. For the best few a path is planned; the goal is the one whose whole way, all that camera
/// and probe meet on it, gains most a second. The camera counts by its rays that the robot itself
/// does not cover in that configuration (OpenRays).
///
/// Voxels that views fail to settle stop counting: unknown or uncovered ones that are in sight of
/// `tries_per_voxel` views the robot was at, and ones whose views have no path (these count again
/// once the map has grown).
///
/// It stops (kComplete) when `stop_tests` reachable views in a row are below the threshold: see
/// PlanNumbers::share_bound for what that says. Unknown voxels left are then declared residual.
class Cfnbv {
 public:
  Cfnbv(const CfnbvConfig& config, const MapConfig& map);
  ~Cfnbv();
  Cfnbv(const Cfnbv&) = delete;
  Cfnbv& operator=(const Cfnbv&) = delete;

  PlanStep Plan(const PlanInput& input, Rng& rng);

  /// Notes where the robot is, for what the probe meets on its way. Microseconds; any rate. Of more
  /// than kMaxPassed places between two plans the oldest are forgotten.
  void Passed(const Configuration& q);

  /// All that failed may be tried anew: where the robot is stuck, what it gave up may be what it
  /// cannot see past itself.
  void ForgetFailures();

  /// Unknown voxels that the last Plan() gave up; the map's owner is to mark them residual.
  std::span<const VoxelIndex> NewResidual() const;

 private:
  struct Candidate;
  struct Memory;

  static constexpr int kMaxPassed = 1024;

  void NoteOutcome(const PlanInput& input);
  void NotePassed(const PlanInput& input, PlanStep& step);
  void Refresh(const VoxelGrid& map);
  void CountTargets(const PlanInput& input, PlanStep& step);
  void Propose(const PlanInput& input, Rng& rng, bool with_kept, PlanStep& step);
  int Evaluate(const PlanInput& input);
  template <typename Visit>
  void WalkWay(const MotionPlanner::Path& path, Visit visit);
  ViewGain WayGain(const MotionPlanner::Path& path);
  void TallyWay(const Configuration& q);
  bool Choose(const PlanInput& input, Rng& rng, PlanStep& step);
  void Accept(const Candidate& candidate, const ViewGain& way, double duration_s, PlanStep& step);
  void Keep();
  void Finish(const PlanInput& input, PlanStep& step);

  CfnbvConfig config_;
  std::unique_ptr<Memory> memory_;
};

}  // namespace pipewright
