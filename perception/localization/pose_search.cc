// SPDX-License-Identifier: MIT
#include "perception/localization/pose_search.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace pipewright {
namespace {

constexpr double kAlikeCosine = 0.8;  ///< of a point's normal and its surfel's
constexpr double kBetter = 1.1;       ///< times the guess's own score
constexpr int kHeadings = 3;          ///< whose neighbourhood is searched

struct Candidate {
  Vector3d pose = Vector3d::Zero();
  double score = -1;
};

class Search {
 public:
  Search(const SurfelMap& map, const PipeLandmarks& pipes, std::span<const ScanPoint> scan,
         const Isometry3d& X_BS, const PoseSearchConfig& config)
      : map_(map),
        pipes_(pipes),
        scan_(scan),
        X_BS_(X_BS),
        config_(config),
        stride_(std::max<std::size_t>(1, scan.size() / static_cast<std::size_t>(config.points))) {}

  Candidate At(const Vector3d& pose) const {
    const Isometry3d X_WS = BaseAt(pose) * X_BS_;
    double score = 0;
    for (std::size_t i = 0; i < scan_.size(); i += stride_) {
      const Vector3d p_WQ = X_WS * scan_[i].p_SQ.cast<double>();
      Surfel of_pipe;
      const Surfel* surfel = pipes_.Find(p_WQ, of_pipe) >= 0 ? &of_pipe : map_.Find(p_WQ);
      if (surfel == nullptr) {
        continue;
      }
      const Vector3d n_W = X_WS.linear() * scan_[i].n_S.cast<double>();
      if (surfel->n_W.dot(n_W) < kAlikeCosine) {
        continue;
      }
      const double r = surfel->n_W.dot(p_WQ - surfel->p_W) / config_.width_m;
      score += 1 / (1 + r * r);
    }
    return {pose, score};
  }

 private:
  const SurfelMap& map_;
  const PipeLandmarks& pipes_;
  std::span<const ScanPoint> scan_;
  const Isometry3d& X_BS_;
  const PoseSearchConfig& config_;
  std::size_t stride_;
};

int Steps(double reach, double step) { return static_cast<int>(std::lround(reach / step)); }

}  // namespace

Vector3d BestStart(const SurfelMap& map, const PipeLandmarks& pipes,
                   std::span<const ScanPoint> scan, const Isometry3d& X_BS, const Vector3d& guess,
                   const PoseSearchConfig& config) {
  assert(Valid(config));
  const Search search(map, pipes, scan, X_BS, config);
  std::array<Candidate, kHeadings> headings;  // best first
  const int turns = Steps(config.turn_rad, config.turn_step_rad);
  for (int k = -turns; k <= turns; ++k) {
    Candidate candidate = search.At(guess + Vector3d(0, 0, k * config.turn_step_rad));
    for (Candidate& held : headings) {
      if (candidate.score > held.score) {
        std::swap(candidate, held);
      }
    }
  }
  const Candidate own = search.At(guess);
  Candidate best = headings[0];
  const int ways = Steps(config.way_m, config.way_step_m);
  for (const Candidate& heading : headings) {
    for (int i = -ways; i <= ways && heading.score >= 0; ++i) {
      for (int j = -ways; j <= ways; ++j) {
        const Vector3d aside(i * config.way_step_m, j * config.way_step_m, 0);
        const Candidate candidate = search.At(heading.pose + aside);
        best = candidate.score > best.score ? candidate : best;
      }
    }
  }
  return best.score > kBetter * own.score ? best.pose : guess;
}

}  // namespace pipewright
