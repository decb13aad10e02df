// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "platform/core/frames.h"
#include "platform/core/status.h"
#include "platform/core/time.h"
#include "platform/core/usable.h"

namespace pipewright {

/// Slip, as the standard deviation after 1 m driven or 1 rad turned; it grows with the root.
struct WheelSlip {
  double m = 0.01;
  double rad_per_m = 0.01;
  double rad_per_rad = 0.01;
};

constexpr bool Valid(const WheelSlip& s) {
  return Usable({s.m, s.rad_per_m, s.rad_per_rad}) && s.m >= 0 && s.rad_per_m >= 0 &&
         s.rad_per_rad >= 0;
}

struct WheelOdometryConfig {
  double track_m = 0.35;       ///< between the drive wheels' contact points
  double quantum_m = 1e-3;     ///< of the cumulative wheel distances
  double max_wheel_mps = 2.5;  ///< a wheel that went faster was not turning: its counter was reset
  Duration max_gap = std::chrono::milliseconds(100);  ///< longer, and speeds are not integrated
  WheelSlip slip{};
};

constexpr bool Valid(const WheelOdometryConfig& c) {
  return Usable({c.track_m, c.quantum_m, c.max_wheel_mps}) && Usable(c.max_gap) && c.track_m > 0 &&
         c.quantum_m > 0 && c.max_wheel_mps > 0 && c.max_gap > Duration::zero() && Valid(c.slip);
}

/// A short way of the base: arc length, and the turn on it.
struct BaseStep {
  double forward_m = 0;
  double turn_rad = 0;
};

/// The pose (x, y, phi) after a step along its exact arc.
Vector3d AlongArc(const Vector3d& pose, const BaseStep& step);

/// Pose of base B in the world W: X_WB = Translation(x, y, 0) RotZ(phi).
struct BasePose {
  Time stamp{};
  double x_m = 0;
  double y_m = 0;
  double phi_rad = 0;                        ///< not wrapped: turns accumulate
  Mat<3, 3> covariance = Mat<3, 3>::Zero();  ///< of (x, y, phi) in W
};

/// Base pose from a differential drive's measured twist and its cumulative wheel distances.
///
/// Each wheel's distance is predicted from the twist, s += (v -+ omega track/2) dt, then held
/// within half a quantum of the distance the base reports. So the fine motion comes from the twist,
/// whose rounding may not accumulate: phi = phi_0 + (s_right - s_left)/track is never farther than
/// 3 quantum/track from the turn of the wheels, however long it runs. The pose is advanced by
/// the exact arc of each step's (ds_left, ds_right). Slip is not seen, but is in the covariance.
class WheelOdometry {
 public:
  explicit WheelOdometry(const WheelOdometryConfig& config = {});

  /// The base is at this pose now; its covariance restarts at zero unless the pose brings one.
  void Reset(const BasePose& pose);

  /// One report of the base: its twist (forward v, yaw rate w) and how far each wheel has gone,
  /// forward positive, as the device rounds it.
  /// kOutOfRange: not finite; ignored. kStale: not newer than the last; ignored.
  /// kFault: a wheel distance jumped; this step went by the twist alone, the next is normal.
  Status Step(Time now, double v_mps, double w_radps, double left_m, double right_m);

  /// How the wheels slip from here on.
  void Slips(const WheelSlip& slip) { config_.slip = slip; }

  const BasePose& pose() const { return pose_; }
  /// By how much the last Step moved the pose.
  const BaseStep& moved() const { return moved_; }

  /// The pose at a moment shortly after the last report (at most max_gap), along its twist.
  BasePose Extrapolate(Time when) const;

  /// Covariance of pose() in W when `then`, an earlier pose() since the last Reset, is taken for
  /// exact: what matters for things that were placed in W by that pose, for what was wrong with it
  /// moved them along with the robot. With S the slip's part of the covariance, R the rounding's,
  ///
  ///   S_now = F S_then F' + S_since,   F = ∂pose/∂then   (turns `then`'s heading about its place)
  ///   covariance = S_since + R + F R F'
  Mat<3, 3> CovarianceSince(const BasePose& then) const;

  std::uint64_t jumps() const { return jumps_; }

 private:
  void Remember(Time now, double v_mps, double w_radps, double left_m, double right_m);
  void Advance(double left_m, double right_m);
  Vector3d RoundingVariance() const;

  WheelOdometryConfig config_;
  BasePose pose_;
  BaseStep moved_;
  Mat<3, 3> slip_covariance_ = Mat<3, 3>::Zero();
  bool started_ = false;
  double v_mps_ = 0;
  double w_radps_ = 0;
  double left_m_ = 0;  ///< estimate of the wheel's distance, in the device's count
  double right_m_ = 0;
  std::uint64_t jumps_ = 0;
};

}  // namespace pipewright
