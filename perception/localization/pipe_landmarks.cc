// SPDX-License-Identifier: MIT
#include "perception/localization/pipe_landmarks.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace pipewright {
namespace {

/// The part of `now` that was seen, on the axis of `held`.
void Extend(PipeEstimate& held, const PipeEstimate& now) {
  const double a = held.l_W.dot(now.p_W + now.extent_lo_m * now.l_W - held.p_W);
  const double b = held.l_W.dot(now.p_W + now.extent_hi_m * now.l_W - held.p_W);
  held.extent_lo_m = std::min(a, b);
  held.extent_hi_m = std::max(a, b);
}

}  // namespace

PipeLandmarks::PipeLandmarks(const PipeLandmarkConfig& config) : config_(config) {
  assert(Valid(config));
}

void PipeLandmarks::Update(const Scene& scene, const Placement& placed) {
  const FixedVector<Landmark, Scene::kMaxPipes> before = pipes_;
  pipes_.clear();
  for (const PipeEstimate& pipe : scene.pipes) {
    const auto* held = std::find_if(before.begin(), before.end(),
                                    [&](const Landmark& l) { return l.pipe.id == pipe.id; });
    if (held != before.end()) {
      static_cast<void>(pipes_.push_back(*held));
      Extend(pipes_[pipes_.size() - 1].pipe, pipe);
    } else if (pipe.frames_seen >= config_.frames_min) {
      static_cast<void>(pipes_.push_back({pipe, placed}));
    }
  }
}

int PipeLandmarks::Find(const Vector3d& p_WQ, Surfel& surface) const {
  double least_m = config_.reach_m;
  int found = -1;
  for (int which = 0; which < pipes_.size(); ++which) {
    const Landmark& landmark = pipes_[which];
    const PipeEstimate& pipe = landmark.pipe;
    const Vector3d w = p_WQ - pipe.p_W;
    const double along = pipe.l_W.dot(w);
    if (landmark.refuted || along < pipe.extent_lo_m + config_.end_m ||
        along > pipe.extent_hi_m - config_.end_m) {
      continue;
    }
    const Vector3d across = w - along * pipe.l_W;
    const double rho = across.norm();
    const double away = std::abs(rho - pipe.radius_m);
    if (away < least_m && rho > 0) {
      least_m = away;
      found = which;
      surface = {};
      surface.n_W = across / rho;
      surface.p_W = p_WQ - (rho - pipe.radius_m) * surface.n_W;
      surface.offset_var_m2 = config_.offset_sigma_m * config_.offset_sigma_m;
      surface.placed = landmark.placed;
    }
  }
  return found;
}

}  // namespace pipewright
