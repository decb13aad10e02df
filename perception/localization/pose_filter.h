// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "perception/localization/dissent.h"
#include "perception/localization/fix_gain.h"
#include "perception/localization/wheel_odometry.h"

namespace pipewright {

struct PoseFilterConfig {
  WheelOdometryConfig odometry{};
  /// Slip as WheelOdometryConfig states it, of a floor of usual grip. The floor's own is found by
  /// the fixes, as a factor of these standard deviations. Each wheel slips by itself: what loses
  /// the base a metre in the mean turns it by 2/track rad.
  WheelSlip slip{.m = 0.0035, .rad_per_m = 0.02, .rad_per_rad = 0.02};
  double slip_start = 1;  ///< the factor before anything is known
  double slip_least = 0.15;
  double slip_most = 10;
  double slip_worst = 30;         ///< of a spill: a wheel may lose a third of 20 cm
  double slip_learning = 0.1;     ///< of its square, a fix
  double yaw_scale_sigma = 0.05;  ///< at start
  double yaw_scale_walk = 0.01;   ///< after 1 rad turned on a floor of usual grip
  double yaw_scale_max = 0.2;     ///< its distance from 1 is held within
  double way_scale_sigma = 0.01;  ///< likewise of the way driven
  double way_scale_walk = 0.002;  ///< after 1 m
  double way_scale_max = 0.05;
  double slow_radps = 0.3;  ///< the yaw scale depends on the speed: one up to this,
  double fast_radps = 0.6;  ///< one from here on, between them in proportion
  FixNoiseConfig fix{};
  int patience = 6;     ///< refused fixes in a row that put the pose in doubt
  int agreement = 3;    ///< fixes in a row that end the doubt, by the pose or against it
  double lost_m = 0.3;  ///< standard deviations beyond which the pose is lost
  double lost_rad = 0.6;
};

constexpr bool Valid(const PoseFilterConfig& c) {
  return Usable({c.slip_start, c.slip_least, c.slip_most, c.slip_learning, c.slip_worst,
                 c.yaw_scale_sigma, c.yaw_scale_walk, c.yaw_scale_max, c.way_scale_sigma,
                 c.way_scale_walk, c.way_scale_max, c.slow_radps, c.fast_radps, c.lost_m,
                 c.lost_rad}) &&
         Valid(c.odometry) && Valid(c.slip) && c.slip_least > 0 && c.slip_start >= c.slip_least &&
         c.slip_most >= c.slip_start && c.slip_worst >= c.slip_most && c.slip_learning >= 0 &&
         c.yaw_scale_sigma >= 0 && c.yaw_scale_walk >= 0 && c.yaw_scale_max > 0 &&
         c.yaw_scale_max < 1 && c.way_scale_sigma >= 0 && c.way_scale_walk >= 0 &&
         c.way_scale_max > 0 && c.way_scale_max < 1 && c.slow_radps >= 0 &&
         c.fast_radps > c.slow_radps && Valid(c.fix) && c.patience >= 0 && c.agreement > 0 &&
         c.lost_m > 0 && c.lost_rad > 0;
}

/// Base pose from wheel odometry, corrected by registered scans: an extended Kalman filter over
/// (x, y, phi, k_slow, k_fast, g), where the base turns 1 + k and drives 1 + g times as far as its
/// wheels tell, with k between k_slow and k_fast by the rate of the turn.
///
/// Prediction by the odometry's steps (s, t), each along its exact arc:
///
///   pose <- pose (+) ((1 + g) s, (1 + k) t),   P <- F P F' + f² (V diag(slip variances) V' + walk
///   of k)
///
/// A fix is older than the newest step when it comes. It corrects the state of its own instant,
/// and the steps since are made again (at most kSteps):
///
///   h = pose at the stamp, J = ∂h/∂state,   state += P J' S⁻¹ (z - h),   P -= P J' S⁻¹ J P
///
/// with S⁻¹ of GainOf(). P is the error among the surroundings that the last fix saw; what the pose
/// and they have in common (CommonWith) is kept beside it, for no fix among them can tell. How
/// slippery the floor is, f, is not known either. Wheels that roll true are far better than fixes,
/// which err the same way for as long as the view lasts; wheels on a wet floor are worse. So f
/// follows the innovations y = z - h: with M = J P J' their part that is the wheels', the
/// likelihood of y is greatest in f² where y' S⁻¹ M S⁻¹ y is its mean, tr(S⁻¹ M), and
///
///   ln f² += learning (y' S⁻¹ M S⁻¹ y / tr(S⁻¹ M) - 1)     after some way, and in bounds
///
/// Where the ratio is what chance does not bring, the wheel is on something else now: f² is
/// multiplied by it at once, and P gets the slip's variances, with the new f, of the way since the
/// last fix, in the directions as well that this fix tells nothing of.
///
/// A fix beyond the gate is refused: it does not move the pose, and puts it in doubt if the base
/// has moved: that it slipped is as likely as a false fix. So do some refused fixes in a row; a
/// scan that fits nowhere is one, too. While doubted() the robot is to stand, and the next fixes
/// tell: some in a row within the gate end the doubt, the pose was right; some in a row beyond it
/// that agree with one another (Dissent) are believed, if they tell the whole pose, or if a slip
/// explains them. Those that tell a part of it may be of something that stands elsewhere than the
/// map has it; and a wheel that does not turn does not slip. So a second covariance is kept beside
/// P, of a base whose floor has been as slippery as any all the way,
///
///   W <- F W F' + slip_worst² V diag(slip variances) V',   W -= W S_W⁻¹ W by each fix taken
///
/// and a part of the pose that is beyond the gate by W, too, is no slip's. Where the fixes are
/// believed, a wheel has slipped by as much as explains their offset y, in the directions of which
/// they tell nothing, too; with b half the track,
///
///   P += diag(e², e², e²/b²),   e = max(|(y_x, y_y)|, b |y_phi|),   f and P likewise
///
/// Offsets beyond what lost() allows are not found again: the robot stops.
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
  /// Its covariance if the wheels have slipped as much as they can: by W.
  Mat<3, 3> worst_covariance() const;
  double yaw_scale_slow() const { return 1 + Newest().x(3); }
  double yaw_scale_fast() const { return 1 + Newest().x(4); }
  double way_scale() const { return 1 + Newest().x(5); }
  /// How slippery the floor is, 1 as usual.
  double slip() const;

  /// The wheels alone; its covariance is by what the fixes told of the floor.
  const WheelOdometry& odometry() const { return odometry_; }

  /// What fixes tell and the pose do not agree: nothing may be added to a map by it, and the robot
  /// is to stand until they do.
  bool doubted() const { return doubted_; }
  /// The pose is too unsure to move by.
  bool lost() const;

  std::uint64_t fixes() const { return fixes_; }
  std::uint64_t refused() const { return refused_; }
  std::uint64_t doubts() const { return doubts_; }
  /// Doubts that ended against the pose.
  std::uint64_t slips() const { return slips_; }

 private:
  struct Moment {
    Time stamp{};
    Vec<6> x = Vec<6>::Zero();
    Mat<6, 6> P = Mat<6, 6>::Zero();
    Mat<3, 3> W = Mat<3, 3>::Zero();
    BaseStep step;    ///< from here to the next moment
    double fast = 0;  ///< k = (1 - fast) k_slow + fast k_fast on it
  };

  /// A fix beside the pose of its stamp.
  struct Instant {
    Vector3d pose = Vector3d::Zero();
    Mat<6, 3> PJ = Mat<6, 3>::Zero();
    FixGain gain;
    Mat<3, 3> WG = Mat<3, 3>::Zero();
    FixGain by_worst;  ///< with W
    double surprise = 1;
  };

  const Moment& Newest() const { return moments_[newest_]; }
  int Before(Time stamp) const;
  BaseStep StepTo(int i, Time stamp) const;
  double Fast(double w_radps) const;
  void Predict(const Moment& from, Moment& to) const;
  void Replay(int from);
  Mat<3, 3> WithShared(Mat<3, 3> covariance) const;
  static double Surprise(const FixGain& gain, const Mat<3, 3>& M);
  void Learn(double surplus);
  void TellOdometry();
  void Doubt(bool moved);
  void Slipped(int i);
  void Startle(int i, double surprise, double way_m);
  void Agree();
  Instant At(int i, const PoseFix& fix) const;
  void Take(int i, const Instant& then);

  PoseFilterConfig config_;
  WheelOdometry odometry_;
  std::array<Moment, kSteps> moments_{};
  Vector3d common_ = Vector3d::Zero();  ///< variances, beside P
  int newest_ = 0;
  int count_ = 1;
  BaseStep rate_;  ///< per second, by the last report
  double slip_squared_;
  double way_m_ = 0;  ///< of the wheels, since the last fix
  Time last_fix_{};
  bool doubted_ = false;
  Dissent dissent_;
  int refused_in_row_ = 0;
  int taken_in_row_ = 0;
  std::uint64_t fixes_ = 0;
  std::uint64_t refused_ = 0;
  std::uint64_t doubts_ = 0;
  std::uint64_t slips_ = 0;
};

}  // namespace pipewright
