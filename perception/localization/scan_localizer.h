// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "perception/cloud/cloud.h"
#include "perception/localization/fix_gain.h"
#include "perception/localization/pose_search.h"
#include "perception/localization/scan_registration.h"
#include "perception/localization/surfel_map.h"
#include "perception/localization/wheel_odometry.h"

namespace pipewright {

struct ScanLocalizerConfig {
  SurfelMapConfig map;
  PipeLandmarkConfig pipes;
  PoseSearchConfig search;
  RegistrationConfig registration{.model_rad = 0.03,
                                  .sigma_max = 1.5e-3,
                                  .points_min = 60,
                                  .known_min = 0.3,
                                  .inliers_min = 0.88};
  double range_m = 2.5;             ///< farther readings are too noisy to be of use
  double range_noise_1pm = 3.8e-3;  ///< σ(z)/z², until told otherwise
  /// Reach of the registration: so many standard deviations of the guess, and a bit. A scan that
  /// may look farther than the base can be finds places that only look like it.
  double reach_sigmas = 2;
  double reach_least_m = 3e-3;
  double reach_most_m = 0.15;
  FixNoiseConfig fix{};       ///< as the pose filter's
  int misfits = 20;           ///< frames in a row, in doubt, before surfels are forgotten
  double misfit_least = 0.6;  ///< share of the points that are inliers, at least
  double jump_m = 0.05;       ///< a frame so far from the guess adds no surfel
  double jump_rad = 0.05;
};

struct ScanLocalizerCounters {
  std::uint64_t scans = 0;
  std::uint64_t fixes = 0;
  std::uint64_t unknown = 0;  ///< too little of it is on known surfaces, or that tells nothing
  std::uint64_t refused = 0;  ///< it did not settle, or does not fit
  std::uint64_t jumps = 0;    ///< fixes far from the guess, or beyond the gate
  std::uint64_t repairs = 0;  ///< times that what most of a frame contradicted was forgotten
};

/// Finds the base by each depth frame among the surfaces that the frames before it showed, and adds
/// what the frame shows: W is the frame in which the first one was taken.
///
/// Of a frame, blocks of readings that are near enough are used; whether a reading is must not hang
/// on its own noise. What is added is told how surely it was placed: see Placement.
///
/// A frame is added where guess and fix together put it, each as far as it is known: by fixes alone
/// the reference would creep, a little with each. One that sees nothing known is added where the
/// guess has it; one that does not fit, jumps, or is beyond the gate, not at all; nor is any while
/// the guess is in doubt. Then it is found in a wider space, too (BestStart), as wide as the wheels
/// may have slipped, and the fix is of what more points are on.
///
/// A reference may be wrong, too: what was added while the base slipped unseen. Where frame after
/// frame in doubt fits in part only, the surfels that contradict them are forgotten, and the pipes
/// refuted.
class ScanLocalizer {
 public:
  static constexpr int kScanPoints = 1024;

  explicit ScanLocalizer(const ScanLocalizerConfig& config = {});

  /// @param cloud  readings in S, X_WS not used
  /// @param guess    of the base at the cloud's stamp, with its covariance
  /// @param doubted  it does not agree with what the frames before told: see PoseFilter
  /// @param worst    its covariance then: see PoseFilter::worst_covariance()
  /// @returns that of Register()
  Status Step(const Cloud& cloud, const Isometry3d& X_BS, const BasePose& guess, bool doubted,
              const Mat<3, 3>& worst, PoseFix& fix);

  /// How noisy the readings are from here on: σ(z)/z², 1/m.
  void Assume(double range_noise_1pm) { config_.range_noise_1pm = range_noise_1pm; }

  /// (x, y, phi) by the last guess and its fix together.
  const Vector3d& pose() const { return pose_; }
  /// Whether the last frame was added: pose() is where it belongs, on any other map as well.
  bool added() const { return added_; }

  /// What is known of pipes, as of the last frame.
  void Take(const Scene& scene) { pipes_.Update(scene, placed_); }

  const SurfelMap& map() const { return map_; }
  const ScanLocalizerCounters& counters() const { return counters_; }
  const RegistrationFigures& figures() const { return figures_; }

 private:
  static constexpr int kBlock = 8;  ///< readings each way

  void MarkUsable(const Cloud& cloud);
  int Select(const Cloud& cloud);
  void Extend(const Cloud& cloud, const Isometry3d& X_WS);
  void Repair(std::span<const ScanPoint> scan, const Isometry3d& X_WS);
  double Reach(const Mat<3, 3>& covariance) const;
  Status Find(std::span<const ScanPoint> scan, const Isometry3d& X_BS, const BasePose& guess,
              bool doubted, const Mat<3, 3>& worst, PoseFix& fix);
  float Sigma(const Eigen::Vector3f& p_SQ) const;

  ScanLocalizerConfig config_;
  SurfelMap map_;
  PipeLandmarks pipes_;
  std::array<bool, Cloud::kMaxPoints> usable_{};
  int usable_count_ = 0;
  std::array<ScanPoint, kScanPoints> scan_{};
  RegistrationFigures figures_;
  ScanLocalizerCounters counters_;
  Vector3d pose_ = Vector3d::Zero();
  Placement placed_;  ///< of pose_
  bool added_ = false;
  int misfits_ = 0;  ///< in a row
};

}  // namespace pipewright
