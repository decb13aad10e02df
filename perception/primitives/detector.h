// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "perception/primitives/pipe_finder.h"
#include "perception/primitives/plane_finder.h"

namespace pipewright {

/// What is believed already, in S: tried before any draw.
struct PrimitiveHints {
  FixedVector<PlaneFit, PlaneFinder::kMaxPlanes> planes;
  FixedVector<CylinderFit, PipeFinder::kMaxPipes> pipes;
};

/// Planes, then pipes among what is left, of one frame. No heap after construction; ~1.5 MB.
class PrimitiveDetector {
 public:
  PrimitiveDetector(const PrimitiveConfig& config, std::uint64_t seed)
      : planes_(config, seed), pipes_(config, seed) {}

  /// How noisy the readings are from here on: DepthNoise::c_1pm.
  void Assume(double noise_1pm) {
    planes_.Assume(noise_1pm);
    pipes_.Assume(noise_1pm);
  }

  void Detect(DepthView& view, const PrimitiveHints& hints) {
    planes_.Find(view, {hints.planes.begin(), hints.planes.end()});
    pipes_.Find(view, {hints.pipes.begin(), hints.pipes.end()},
                {planes_.found().begin(), planes_.found().end()});
  }

  const FixedVector<DetectedPlane, PlaneFinder::kMaxPlanes>& planes() const {
    return planes_.found();
  }
  const FixedVector<DetectedPipe, PipeFinder::kMaxPipes>& pipes() const { return pipes_.found(); }

 private:
  PlaneFinder planes_;
  PipeFinder pipes_;
};

}  // namespace pipewright
