// SPDX-License-Identifier: MIT
#include "hil/world/truth.h"

#include <algorithm>
#include <limits>

namespace pipewright::hil {

Truth::Truth(const Scenario& scenario, const RobotBodies& robot)
    : surface_(SampleSurface(scenario)),
      rays_(scenario.solids),
      probe_(surface_, rays_, kProbeRadius_m),
      coverable_(CachedCoverable(scenario, robot, probe_)),
      meter_(scenario.solids, robot),
      covered_(surface_.voxels.size(), 0),
      min_plane_m_(std::numeric_limits<double>::infinity()),
      min_pipe_m_(std::numeric_limits<double>::infinity()),
      min_self_m_(std::numeric_limits<double>::infinity()) {}

const Clearance& Truth::Measure(std::span<const Isometry3d> X_WL) {
  now_ = meter_.Measure(X_WL);
  min_plane_m_ = std::min(min_plane_m_, now_.plane.distance_m);
  min_pipe_m_ = std::min(min_pipe_m_, now_.pipe.distance_m);
  min_self_m_ = std::min(min_self_m_, now_.self.distance_m);
  return now_;
}

int Truth::Cover(const Vector3d& p_WP) { return probe_.Add(p_WP, covered_); }

Truth::Coverage Truth::coverage() const {
  Coverage c;
  c.surface = static_cast<int>(covered_.size());
  for (std::size_t i = 0; i < covered_.size(); ++i) {
    c.covered += covered_[i];
    c.coverable += covered_[i] | coverable_.coverable[i];
  }
  c.ratio = c.coverable > 0 ? static_cast<double>(c.covered) / c.coverable : 1;
  return c;
}

}  // namespace pipewright::hil
