// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "perception/localization/scan_registration.h"
#include "perception/localization/wheel_odometry.h"

namespace pipewright {

struct PoseFilterConfig {
  WheelOdometryConfig odometry;
  /// Slip between two fixes, as WheelOdometryConfig states it, but of a floor that may be wet.
  double slip_m = 0.05;
  double slip_rad_per_m = 0.1;
  double slip_rad_per_rad = 0.1;
  double yaw_scale_sigma = 0.05;  ///< at start
  double yaw_scale_walk = 0.02;   ///< after 1 rad turned; it depends on the speed
  double yaw_scale_max = 0.2;     ///< its distance from 1 is held within
  double fix_sigma_m = 1.5e-3;    ///< what all fixes share: the reference's own error, rounding
  double fix_sigma_rad = 3e-3;
  double gate = 25;      ///< chi-square of three degrees of freedom: 1.5e-5 by chance
  double lost_m = 0.15;  ///< standard deviations beyond which the pose is lost
  double lost_rad = 0.3;
};

constexpr bool Valid(const PoseFilterConfig& c) {
  return Valid(c.odometry) && c.slip_m >= 0 && c.slip_rad_per_m >= 0 && c.slip_rad_per_rad >= 0 &&
         c.yaw_scale_sigma >= 0 && c.yaw_scale_walk >= 0 && c.yaw_scale_max > 0 &&
         c.yaw_scale_max < 1 && c.fix_sigma_m > 0 && c.fix_sigma_rad > 0 && c.gate > 0 &&
         c.lost_m > 0 && c.lost_rad > 0;
}

/// Base pose from wheel odometry, corrected by registered scans: an extended Kalman filter over
/// (x, y, phi, k), where the base turns (1 + k) times as far as its wheels tell.
///
/// Prediction by the odometry's steps (s, t), each along its exact arc:
///
///   pose <- pose (+) (s, (1 + k) t),   P <- F P F' + V diag(slip variances) V' + walk of k
///
/// A fix is older than the newest step when it comes. It corrects the state of its own instant,
/// and the steps since are made again (at most kSteps):
///
///   h = pose at the stamp, J = ∂h/∂state,   L = (I⁻¹ + Σ_fix)⁻¹,   I the fix's information
///   S⁻¹ = (J P J' + L⁻¹)⁻¹,   state += P J' S⁻¹ (z - h),   P -= P J' S⁻¹ J P
///
/// S⁻¹ is computed from L = C C' as C (1 + C' J P J' C)⁻¹ C', which a direction without information
/// leaves alone. A fix with (z - h)' S⁻¹ (z - h) above the gate is refused: it does not move the
/// pose. But then one of both is wrong, so P is widened. A fix that lies is soon forgotten; when
/// they all insist, the pose first gets unsure, then lost() stops the robot, unless it was the
/// wheels that lied and the fixes fit the wider P. A scan that fits nowhere is a doubt of that
/// kind.
///
/// No heap. Step: ~0.5 us. Correct: kSteps of these at most.
class PoseFilter {
 public:
  static constexpr int kSteps = 24;  ///< 20 ms each: how old a fix may be

  explicit PoseFilter(const PoseFilterConfig& config = {});

  void Reset(const BasePose& pose);

  /// As WheelOdometry::Step.
  Status Step(Time now, double v_mps, double w_radps, double left_m, double right_m);

  /// kStale: older than the steps held, or not newer than the last fix. kOutOfRange: not finite, or
  /// later than the odometry can tell. kInfeasible: beyond the gate, or it fits nowhere.
  Status Correct(const PoseFix& fix);

  /// At the last report, with what all fixes share in the covariance once there was one.
  BasePose pose() const;
  /// Shortly after it, along its twist.
  BasePose Extrapolate(Time when) const;
  double yaw_scale() const { return 1 + Newest().x(3); }

  /// The wheels alone.
  const WheelOdometry& odometry() const { return odometry_; }

  /// The pose is too unsure to move by.
  bool lost() const;

  std::uint64_t fixes() const { return fixes_; }
  std::uint64_t refused() const { return refused_; }

 private:
  struct Moment {
    Time stamp{};
    Vec<4> x = Vec<4>::Zero();
    Mat<4, 4> P = Mat<4, 4>::Zero();
    BaseStep step;  ///< from here to the next moment
  };

  const Moment& Newest() const { return moments_[newest_]; }
  int Before(Time stamp) const;
  BaseStep StepTo(int i, Time stamp) const;
  void Predict(const Moment& from, Moment& to) const;
  void Replay(int from);
  void Doubt(int i);

  PoseFilterConfig config_;
  WheelOdometry odometry_;
  std::array<Moment, kSteps> moments_{};
  int newest_ = 0;
  int count_ = 1;
  BaseStep rate_;  ///< per second, by the last report
  Time last_fix_{};
  std::uint64_t fixes_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace pipewright
