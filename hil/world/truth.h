// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hil/world/clearance.h"
#include "hil/world/coverable.h"
#include "hil/world/coverage.h"

namespace pipewright::hil {

/// What really happened in a run: contacts, clearances, coverage. Knows the world, tells no one but
/// the report. scenario and robot must outlive it.
class Truth {
 public:
  static constexpr double kProbeRadius_m = 0.4;

  Truth(const Scenario& scenario, const RobotBodies& robot);

  /// Once per control cycle: clearances and contacts. Some tens of microseconds.
  const Clearance& Measure(std::span<const Isometry3d> X_WL);
  /// When the probe has moved (or each 50 ms): marks what it covers now; returns how many are new.
  int Cover(const Vector3d& p_WP);

  /// Smallest clearances since the start, by kind [m].
  double min_plane_m() const { return min_plane_m_; }
  double min_pipe_m() const { return min_pipe_m_; }
  double min_self_m() const { return min_self_m_; }
  int contacts() const { return meter_.contact_episodes(); }
  const std::vector<std::string>& touched() const { return meter_.touched(); }

  struct Coverage {
    int surface = 0;    ///< surface voxels in W
    int coverable = 0;  ///< coverable, or covered in this run
    int covered = 0;
    double ratio = 1;  ///< covered / coverable; 1 when there is nothing to cover
  };
  Coverage coverage() const;
  const SurfaceVoxels& surface() const { return surface_; }
  const std::vector<std::uint8_t>& covered() const { return covered_; }
  const CoverableSet& coverable() const { return coverable_; }

 private:
  SurfaceVoxels surface_;
  RayScene rays_;
  CoverageProbe probe_;
  CoverableSet coverable_;
  ClearanceMeter meter_;
  Clearance now_;
  std::vector<std::uint8_t> covered_;
  double min_plane_m_;
  double min_pipe_m_;
  double min_self_m_;
};

}  // namespace pipewright::hil
