// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "perception/primitives/depth_view.h"
#include "perception/primitives/fit.h"
#include "perception/primitives/pipe_readings.h"
#include "perception/primitives/pixel_distance.h"
#include "perception/primitives/plane_finder.h"
#include "platform/core/fixed_vector.h"
#include "platform/core/rng.h"

namespace pipewright {

/// A pipe of one frame and the part of its axis that was seen.
struct DetectedPipe {
  CylinderFit fit;
  double lo_m = 0;  ///< along l from p
  double hi_m = 0;
};

/// Depth z at which the ray (x, y, 1) enters the cylinder between lo and hi of its axis, or
/// nothing.
std::optional<double> DepthOfPipe(const Vector3d& ray_S, const CylinderFit& pipe, double lo_m,
                                  double hi_m);

/// Cylinders among the readings that no plane explains.
///
/// A draw takes a reading and those about it on the same surface. Their normals, and their spread,
/// each give an axis direction; a circle across it the rest. The draw that most readings agree with
/// is refined on them. A pipe must be round (a plane fits worse), convex, show enough of its
/// circumference, and hide what is behind it.
class PipeFinder {
 public:
  static constexpr int kMaxPipes = 16;

  PipeFinder(const PrimitiveConfig& config, std::uint64_t seed) : config_(config), rng_(seed, 2) {}

  /// How noisy the readings are from here on: DepthNoise::c_1pm.
  void Assume(double noise_1pm) { config_.noise.c_1pm = noise_1pm; }

  /// Tries `hints` first. `planes` are those of the same view: what is near them is not judged.
  /// Cost: see PrimitiveDetector.
  void Find(DepthView& view, std::span<const CylinderFit> hints,
            std::span<const DetectedPlane> planes);

  const FixedVector<DetectedPipe, kMaxPipes>& found() const { return found_; }

 private:
  static constexpr int kMaxSamples = 512;
  static constexpr int kMaxPatch = 256;
  static constexpr int kMaxPoints = 1200;   ///< of one pipe; more are thinned
  static constexpr int kRoughPoints = 300;  ///< the same before its last fit

  struct Hypothesis {
    CylinderFit pipe;
    int score = 0;
  };

  void Gather(const DepthView& view);
  void Sample();
  Hypothesis Draw(const DepthView& view);
  int Patch(const DepthView& view, int seed);
  bool FromDirection(const Vector3d& l_S, int patch, CylinderFit& pipe);
  void Keep(const CylinderFit& pipe, Hypothesis& best) const;
  int Score(const CylinderFit& pipe) const;
  template <typename Use>
  void ForAgreeing(const CylinderFit& pipe, const Use& use) const;
  int Collect(const CylinderFit& pipe, DetectedPipe& bounds);
  bool Consider(DepthView& view, const Hypothesis& hypothesis);
  void Bar(const CylinderFit& pipe);
  void Take(int k);
  bool Refine(const Hypothesis& hypothesis, DetectedPipe& pipe);
  int CollectAlongRays(const DepthView& view, const DetectedPipe& pipe, int& step);
  PixelBox MarkAlongRays(const DepthView& view, const DetectedPipe& pipe);
  void MeasureFromOthers(const DepthView& view, const PixelBox& box);
  bool NearAnother(const Vector3d& p_SQ, double sigma_m) const;
  bool Polish(const DepthView& view, DetectedPipe& pipe);
  bool IsPipe(const DepthView& view, const DetectedPipe& pipe, int count) const;
  bool HidesWhatIsBehind(const DepthView& view, const DetectedPipe& pipe) const;
  double Arc(const CylinderFit& pipe, int count) const;
  void Claim(DepthView& view, const DetectedPipe& pipe);

  PrimitiveConfig config_;
  Rng rng_;
  FixedVector<DetectedPipe, kMaxPipes> found_;
  std::span<const DetectedPlane> planes_;  ///< while Find() runs
  PipeReadings<DepthView::kMaxPixels> reading_;
  std::array<int, DepthView::kMaxPixels> pixel_{};                     ///< of each reading
  std::array<std::uint8_t, DepthView::kMaxPixels + kLanes> barred_{};  ///< used, or of no pipe
  std::array<std::int16_t, DepthView::kMaxPixels> reading_of_{};  ///< by pixel; -1: none, or barred
  std::array<int, kMaxSamples> sample_{};                         ///< readings that are not barred
  PipeReadings<kMaxSamples> sampled_;
  std::array<int, kMaxPatch> patch_{};
  // By pixel, where the ray meets the pipe that is looked at.
  enum class Side : std::uint8_t { kNone, kOnPipe, kGoesOn };
  std::array<Side, DepthView::kMaxPixels + kLanes> side_{};
  std::array<float, DepthView::kMaxPixels + kLanes> z_on_pipe_m_{};  ///< where kOnPipe
  std::array<float, DepthView::kMaxPixels + kLanes> along_pipe_m_{};
  std::array<std::uint8_t, DepthView::kMaxPixels> from_other_{};  ///< pixels
  // Readings that agree with the pipe that is looked at, and those it is fitted to.
  std::array<int, DepthView::kMaxPixels> agree_{};
  std::array<float, DepthView::kMaxPixels> along_m_{};
  std::array<Eigen::Vector3f, kMaxPoints> point_;
};

}  // namespace pipewright
