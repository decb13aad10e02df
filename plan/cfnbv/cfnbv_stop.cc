// SPDX-License-Identifier: MIT
// The stopping rule: what is left, and when W is complete.
#include <cmath>

#include "perception/map/voxel_grid.h"
#include "plan/cfnbv/cfnbv_memory.h"

namespace pipewright {
namespace {

/// Fewer tests than this share of stop_tests say too little to call W complete.
constexpr double kTestsShare = 0.25;
constexpr double kMissChance = 0.01;

}  // namespace

void Cfnbv::CountTargets(const PlanInput& input, PlanStep& step) {
  Memory& m = *memory_;
  const MapCounts& counts = input.map.counts();
  step.numbers.unknown_targets = static_cast<int>(m.gains.Unknown().size());
  step.numbers.uncovered_targets = static_cast<int>(m.gains.Uncovered().size());
  step.numbers.surface_targets = static_cast<int>(m.surface.patches().size());
  step.numbers.given_up = counts.occupied - counts.covered - step.numbers.uncovered_targets;
}

/// Nothing worthwhile is left: says what that means, and gives up the unknown voxels.
void Cfnbv::Finish(const PlanInput& input, PlanStep& step) {
  const MapCounts& counts = input.map.counts();
  const int tested = step.numbers.tested;
  const bool enough = NothingLeft(step.numbers) || tested >= kTestsShare * config_.stop_tests;
  const int known = counts.free + counts.occupied;
  if (tested > 0) {
    step.numbers.share_bound = 1 - std::pow(kMissChance, 1.0 / tested);
  }
  if (!enough || known < config_.complete_known_share * counts.total ||
      counts.covered < config_.complete_covered_share * counts.occupied) {
    return;
  }
  step.decision = PlanDecision::kComplete;
  const VoxelIndex& lo = input.map.config().workspace_lo;
  const VoxelIndex& hi = input.map.config().workspace_hi;
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        const VoxelIndex v{x, y, z};
        if (input.map.State(v) == VoxelState::kUnknown && !input.map.Residual(v)) {
          memory_->residual.push_back(v);
        }
      }
    }
  }
  step.numbers.residual_new = static_cast<int>(memory_->residual.size());
}

}  // namespace pipewright
