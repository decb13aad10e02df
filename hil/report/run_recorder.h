// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "hil/report/plot.h"
#include "platform/core/frames.h"

namespace pipewright::hil {

inline constexpr double kNoReading = std::numeric_limits<double>::quiet_NaN();

/// What the plots hold values against; what is not known is not drawn.
struct RunLimits {
  double base_mps = kNoReading;
  double base_radps = kNoReading;
  double joint_radps = kNoReading;
  double reached = kNoReading;    ///< task error of a goal that is reached
  double period_us = kNoReading;  ///< of the control task
  double coverage_target = 0.95;
};

/// One control cycle. A value that is not finite leaves a gap.
struct CycleSample {
  double true_plane_m = kNoReading;  ///< clearances as they were
  double true_pipe_m = kNoReading;
  double true_self_m = kNoReading;
  double seen_plane_m = kNoReading;  ///< clearances as the controller saw them
  double seen_pipe_m = kNoReading;
  double seen_self_m = kNoReading;
  double seen_obstacle_m = kNoReading;
  double task_error = kNoReading;  ///< ‖x − x_d‖
  double base_mps = kNoReading;    ///< commands as sent
  double base_radps = kNoReading;
  std::array<double, 7> joint_radps{};
  double rows = kNoReading;
  double qp_iterations = kNoReading;
  double qp_us = kNoReading;     ///< wall clock
  double cycle_us = kNoReading;  ///< wall clock
};

/// What changes more slowly: a sample each 0.1 s is plenty.
struct MapSample {
  double coverage_ratio = kNoReading;  ///< of the truth
  double free = kNoReading;            ///< voxels of the workspace
  double occupied = kNoReading;
  double unknown = kNoReading;
  double covered = kNoReading;
  double visual_entropy = kNoReading;    ///< nats per voxel
  double coverage_entropy = kNoReading;  ///< nats per voxel
  double base_bus_load = kNoReading;     ///< 0 to 1
  double arm_bus_load = kNoReading;
  Vector3d p_WP{kNoReading, kNoReading, kNoReading};  ///< the probe
};

/// Records a run for its page in fixed memory (some 0.7 MB), see Sampler.
///
///   RunRecorder recorder(limits);
///   recorder.Cycle(t_s, sample);   // every control cycle; below a microsecond
///   recorder.Map(t_s, sample);     // each 0.1 s
///   input.plots = recorder.Plots();
///   input.world.hand_path = recorder.hand_path();
class RunRecorder {
 public:
  explicit RunRecorder(const RunLimits& limits);

  void Cycle(double t_s, const CycleSample& sample);
  void Map(double t_s, const MapSample& sample);

  /// The page's plots, in its order; a signal that never had a value is left out.
  std::vector<Plot> Plots() const;

  /// Positions of the probe, at least path_step_m apart; at most 4000.
  const std::vector<Vector3d>& hand_path() const { return hand_path_; }

 private:
  enum Signal : int {
    kTruePlane,
    kTruePipe,
    kTrueSelf,
    kSeenPlane,
    kSeenPipe,
    kSeenSelf,
    kSeenObstacle,
    kTaskError,
    kBaseSpeed,
    kBaseTurn,
    kRows,
    kQpIterations,
    kQpTime,
    kCycleTime,
    kCoverage,
    kFree,
    kOccupied,
    kUnknown,
    kCovered,
    kVisualEntropy,
    kCoverageEntropy,
    kCombinedEntropy,
    kBaseBus,
    kArmBus,
    kJoint1,
    kSignals = kJoint1 + 7,
  };

  void AddToPath(const Vector3d& p_WP);
  Plot MakePlot(Plot head, std::initializer_list<std::pair<Signal, const char*>> signals) const;

  RunLimits limits_;
  std::array<Sampler, kSignals> signals_;
  std::vector<Vector3d> hand_path_;
  double path_step_m_ = 0.01;
};

}  // namespace pipewright::hil
