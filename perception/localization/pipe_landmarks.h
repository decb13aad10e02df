// SPDX-License-Identifier: MIT
#pragma once

#include "perception/localization/surfel_map.h"
#include "perception/scene.h"

namespace pipewright {

struct PipeLandmarkConfig {
  int frames_min = 20;           ///< in which a pipe was seen before it is one
  double reach_m = 0.03;         ///< of a point from its surface
  double end_m = 0.03;           ///< at an end, points are of something else
  double offset_sigma_m = 2e-3;  ///< of its surface
};

constexpr bool Valid(const PipeLandmarkConfig& c) {
  return c.frames_min > 0 && c.reach_m > 0 && c.end_m >= 0 && c.offset_sigma_m > 0;
}

/// The scene's pipes, each held where it was when it was well known: a track follows the robot's
/// pose, and what follows it is no reference. A pipe that the scene gives up is forgotten; one that
/// turned out not to be where it was held is no landmark again while the scene has it.
class PipeLandmarks {
 public:
  explicit PipeLandmarks(const PipeLandmarkConfig& config = {});

  /// @param placed  of the base, by which new ones are placed
  void Update(const Scene& scene, const Placement& placed = {});

  /// The nearest pipe's surface at the point, when it is within reach. @returns which; -1: none
  int Find(const Vector3d& p_WQ, Surfel& surface) const;

  /// What is seen there contradicts it.
  void Refute(int which) { pipes_[which].refuted = true; }

  int size() const { return pipes_.size(); }

 private:
  struct Landmark {
    PipeEstimate pipe;
    Placement placed;
    bool refuted = false;
  };

  PipeLandmarkConfig config_;
  FixedVector<Landmark, Scene::kMaxPipes> pipes_;
};

}  // namespace pipewright
