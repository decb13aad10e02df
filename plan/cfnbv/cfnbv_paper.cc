// SPDX-License-Identifier: MIT
#include "plan/cfnbv/cfnbv_paper.h"

#include <cmath>
#include <numbers>

#include "perception/map/voxel_grid.h"

namespace pipewright {
namespace {

int Cells(const MapConfig& map) {
  const VoxelIndex& lo = map.workspace_lo;
  const VoxelIndex& hi = map.workspace_hi;
  return (hi.x - lo.x + 1) * (hi.y - lo.y + 1) * (hi.z - lo.z + 1);
}

/// n of section IV-D: pan about z_W, tilt up from the horizontal.
Vector3d RandomDirection(Rng& rng) {
  const double pan = rng.Uniform(-std::numbers::pi, std::numbers::pi);
  const double tilt = rng.Uniform(-std::numbers::pi / 2, std::numbers::pi / 2);
  return {std::cos(tilt) * std::cos(pan), std::cos(tilt) * std::sin(pan), std::sin(tilt)};
}

}  // namespace

CfnbvPaper::CfnbvPaper(const CfnbvPaperConfig& config, const MapConfig& map)
    : config_(config), map_(map), gains_(config.gain, map) {
  assert(Valid(config));
  free_.reserve(static_cast<std::size_t>(Cells(map)));
}

void CfnbvPaper::CollectFree(const VoxelGrid& map) {
  free_.clear();
  const VoxelIndex& lo = map_.workspace_lo;
  const VoxelIndex& hi = map_.workspace_hi;
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        if (map.State({x, y, z}) == VoxelState::kFree) {
          free_.push_back(map_.width_m * Vector3d(x + 0.5, y + 0.5, z + 0.5));
        }
      }
    }
  }
}

PlanStep CfnbvPaper::Plan(const PlanInput& input, Rng& rng) {
  PlanStep step;
  CollectFree(input.map);
  if (free_.empty()) {
    return step;
  }
  gains_.Update(input.map);
  double best = -1;
  for (int i = 0; i < config_.candidates; ++i) {
    const Vector3d& p_WS =
        free_[static_cast<std::size_t>(rng.Index(static_cast<int>(free_.size())))];
    const Viewpoint view = UprightViewpoint(p_WS, RandomDirection(rng));
    const RaySet camera = RandomCameraRays(config_.gain, rng);
    const RaySet probe = RandomSphereRays(config_.gain, rng);
    const ViewGain gain = gains_.Evaluate(view, camera, probe, GainCount::kPerRay);
    const double weighted = WeightedGain(config_.gain, gain);
    if (weighted > best) {
      best = weighted;
      step.goal.p_WS = p_WS;
      step.goal.z_WS = view.X_WS.linear().col(2);
      step.numbers.gain_visual = gain.visual_nats;
      step.numbers.gain_coverage = gain.coverage_nats;
      step.numbers.gain_weighted = weighted;
    }
  }
  step.numbers.candidates = config_.candidates;
  step.numbers.reachable = config_.candidates;
  if (best < config_.stop_gain) {
    step.decision = PlanDecision::kComplete;
    step.goal = Goal{};
    return step;
  }
  step.decision = PlanDecision::kGoal;
  step.goal.id = next_id_++;
  return step;
}

}  // namespace pipewright
