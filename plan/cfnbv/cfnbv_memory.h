// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <vector>

#include "plan/cfnbv/cfnbv.h"
#include "plan/cfnbv/failures.h"
#include "plan/cfnbv/open_rays.h"
#include "plan/gain/gain.h"
#include "plan/gain/surface.h"
#include "plan/motion/edge.h"
#include "plan/motion/motion_planner.h"
#include "platform/robot/uf7.h"

namespace pipewright {

struct Cfnbv::Candidate {
  Configuration q = Configuration::Zero();
  Viewpoint view;
  CandidateKind kind = CandidateKind::kUniform;
  ViewGain gain;
  double weighted = 0;  ///< (23) and room, nats
  double score = 0;     ///< nats a second, by the least time; 0: not to be taken
  int stalls = 0;       ///< near the view
  bool room = false;    ///< worth the way for the room it gives only
};

/// All that a Cfnbv keeps from step to step, and its room to work in.
struct Cfnbv::Memory {
  static constexpr int kMaxKept = 24;
  static constexpr int kMaxCandidates = 1000 + kMaxKept;

  Memory(const CfnbvConfig& config, const MapConfig& map)
      : gains(config.gain, map),
        surface(map),
        motion(config.motion),
        camera(LatticeCameraRays(config.gain)),
        failures(gains.workspace_voxels(), config.tries_per_voxel, config.stall_radius_m) {
    residual.reserve(static_cast<std::size_t>(gains.workspace_voxels()));
  }

  /// What of the camera the robot does not cover itself in q; until the next call.
  const RaySet& OpenAt(const Configuration& q) {
    OpenRays(q, camera, open);
    return open;
  }

  GainEvaluator gains;
  SurfaceToCover surface;
  Vector3d passed[kMaxPassed];  ///< places of the probe since the last plan
  int passed_count = 0;         ///< ever; the newest kMaxPassed are held
  MotionPlanner motion;
  RaySet camera;
  RaySet open;
  Failures failures;
  FixedVector<Candidate, kMaxCandidates> candidates;
  FixedVector<Configuration, kMaxKept> kept;
  std::vector<VoxelIndex> residual;
  EdgeSpeeds speeds = SpeedsOf(TracerUf7());
  Viewpoint last_view;
  std::uint32_t last_id = 0;  ///< of the last goal; 0: none
  bool last_is_room = false;
  bool cramped = false;  ///< this round: hardly any candidate but the far ones is free
  MotionPlanner::Path last_path;
  int room_goals = 0;  ///< since W's map last grew by forget_voxels
  int known_at_pathless = 0;
  MotionPlanner::Path path;
};

/// No target is left of any kind.
inline bool NothingLeft(const PlanNumbers& n) {
  return n.unknown_targets == 0 && n.uncovered_targets == 0 && n.surface_targets == 0;
}

}  // namespace pipewright
