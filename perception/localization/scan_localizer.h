// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "perception/cloud/cloud.h"
#include "perception/localization/scan_registration.h"
#include "perception/localization/surfel_map.h"

namespace pipewright {

struct ScanLocalizerConfig {
  SurfelMapConfig map;
  RegistrationConfig registration{.points_min = 60, .known_min = 0.3, .inliers_min = 0.8};
  double range_m = 2.5;             ///< farther readings are too noisy to be of use
  double range_noise_1pm = 3.8e-3;  ///< σ(z)/z²
  double far_reach_m = 0.15;        ///< of a second try, when a frame does not fit
  double jump_m = 0.05;             ///< a fix that far from the guess places no surfel
  double jump_rad = 0.05;
};

struct ScanLocalizerCounters {
  std::uint64_t scans = 0;
  std::uint64_t fixes = 0;
  std::uint64_t unknown = 0;  ///< too little of it is on known surfaces, or that tells nothing
  std::uint64_t refused = 0;  ///< it did not settle, or does not fit
  std::uint64_t jumps = 0;    ///< fixes far from the guess
};

/// Finds the base by each depth frame among the surfaces that the frames before it showed, and adds
/// what the frame shows: W is the frame in which the first one was taken.
///
/// A frame is added where its own fix puts it; one that sees nothing known, where the guess does;
/// one that does not fit, or jumps, not at all.
class ScanLocalizer {
 public:
  static constexpr int kScanPoints = 1024;

  explicit ScanLocalizer(const ScanLocalizerConfig& config = {});

  /// @param cloud  readings in S, X_WS not used
  /// @param guess  (x, y, phi) of the base at the cloud's stamp
  /// @returns that of Register()
  Status Step(const Cloud& cloud, const Isometry3d& X_BS, const Vector3d& guess, PoseFix& fix);

  /// Whether the last fix was near its guess.
  bool trusted() const { return trusted_; }

  const SurfelMap& map() const { return map_; }
  const ScanLocalizerCounters& counters() const { return counters_; }
  const RegistrationFigures& figures() const { return figures_; }

 private:
  int Select(const Cloud& cloud);
  void Extend(const Cloud& cloud, const Isometry3d& X_WS);
  float Sigma(const Eigen::Vector3f& p_SQ) const;

  ScanLocalizerConfig config_;
  SurfelMap map_;
  std::array<ScanPoint, kScanPoints> scan_{};
  RegistrationFigures figures_;
  ScanLocalizerCounters counters_;
  bool trusted_ = false;
};

}  // namespace pipewright
