// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "perception/primitives/depth_view.h"
#include "perception/primitives/fit.h"
#include "platform/core/fixed_vector.h"
#include "platform/core/rng.h"

namespace pipewright {

/// A plane of one frame and the rectangle of it that was seen: e1 horizontal in W (or, for a floor,
/// along x_W), e1 × e2 = n.
struct DetectedPlane {
  PlaneFit fit;
  Vector3d p_SCentroid = Vector3d::Zero();
  Vector3d e1_S = Vector3d::UnitX();
  Vector3d e2_S = Vector3d::UnitY();
  double lo_m[2] = {0, 0};  ///< along e1, e2 from the centroid
  double hi_m[2] = {0, 0};
};

/// In-plane axes of a plane's rectangle: columns e1, e2 for normal n, in the frame in which up and
/// forward are z_W and x_W.
Eigen::Matrix<double, 3, 2> RectangleAxes(const Vector3d& n, const Vector3d& up,
                                          const Vector3d& forward);

/// Whether a point lies within max(sigmas of its noise, least_m) of a plane and about its
/// rectangle.
bool Near(const DetectedPlane& plane, const Vector3d& p_SQ, const DepthNoise& noise, double sigmas,
          double least_m);

/// Planes by RANSAC over triples of readings, refined by least squares, one after the other.
///
/// A plane must explain its readings to within their noise, fill enough of its rectangle, and be
/// wider than any pipe. Readings of planes are marked so in the view.
class PlaneFinder {
 public:
  static constexpr int kMaxPlanes = 16;

  PlaneFinder(const PrimitiveConfig& config, std::uint64_t seed) : config_(config), rng_(seed, 1) {}

  /// How noisy the readings are from here on: DepthNoise::c_1pm.
  void Assume(double noise_1pm) { config_.noise.c_1pm = noise_1pm; }

  /// Tries `hints` first. Cost: O(pixels) a plane.
  void Find(DepthView& view, std::span<const PlaneFit> hints);

  const FixedVector<DetectedPlane, kMaxPlanes>& found() const { return found_; }

 private:
  static constexpr int kMaxSamples = 1024;

  struct Hypothesis {
    Eigen::Vector3f m = Eigen::Vector3f::Zero();  ///< n/d: 1/z = m'x
    int score = 0;
  };

  /// Pixels begin ... end − 1 of one row.
  struct Run {
    int begin;
    int end;
    int parent;  ///< a run of the same island; itself: the island's first
    int size;    ///< of the island, where it is its first
  };

  void Unbar(const DepthView& view);
  void Search(DepthView& view, std::span<const PlaneFit> hints);
  void Sample(const DepthView& view);
  int Score(const Eigen::Vector3f& m) const;
  Hypothesis Draw(const DepthView& view);
  bool Consider(DepthView& view, const Hypothesis& hypothesis, int rounds);
  void Bar(const DepthView& view);
  bool Refine(const DepthView& view, Eigen::Vector3f m, int rounds, PlaneFit& fit);
  int Collect(const DepthView& view, const Eigen::Vector3f& m, double sigmas);
  int KeepLargeParts(const DepthView& view, int count);
  bool Bound(const DepthView& view, int count, DetectedPlane& plane) const;
  void MeasureFromOthers(const DepthView& view, const Eigen::Vector3f& m);
  void MarkCorners(const DepthView& view, const Eigen::Vector3f& m, const DetectedPlane& plane);
  bool Polish(const DepthView& view, DetectedPlane& plane);
  int Support(const DepthView& view, int i) const;
  void Claim(DepthView& view, const DetectedPlane& plane) const;

  PrimitiveConfig config_;
  Rng rng_;
  FixedVector<DetectedPlane, kMaxPlanes> found_;
  // Samples of the readings that are still free.
  int samples_ = 0;
  std::array<int, kMaxSamples> sample_{};
  std::array<float, kMaxSamples> x_{};
  std::array<float, kMaxSamples> y_{};
  std::array<float, kMaxSamples> w_{};
  std::array<float, kMaxSamples> inverse_sigma_{};
  // The readings on the plane that is looked at.
  std::array<int, DepthView::kMaxPixels + 1> inlier_{};
  std::array<Eigen::Vector3f, DepthView::kMaxPixels> point_;
  std::array<std::uint8_t, DepthView::kMaxPixels + kLanes> mark_{};  ///< 1 on the plane, 3 kept
  std::array<std::uint8_t, DepthView::kMaxPixels> barred_{};  ///< led to no plane in this frame
  std::array<std::uint8_t, DepthView::kMaxPixels + kLanes> from_other_{};  ///< pixels
  std::array<int, DepthView::kMaxPixels + 1> free_{};
  std::array<Run, DepthView::kMaxPixels / 2 + 1> run_;
};

}  // namespace pipewright
