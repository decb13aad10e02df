// SPDX-License-Identifier: MIT
#include "plan/motion/edge.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

constexpr double kSamePlace_m = 1e-4;  // nearer than this the base only turns

double Share(double s, double from, double to) {
  return to > from ? std::clamp((s - from) / (to - from), 0.0, 1.0) : (s >= to ? 1.0 : 0.0);
}

}  // namespace

double WrapAngle(double angle_rad) {
  const double wrapped = std::remainder(angle_rad, 2 * std::numbers::pi);
  return wrapped == -std::numbers::pi ? std::numbers::pi : wrapped;
}

EdgeSpeeds SpeedsOf(const RobotModel<kArmJoints>& robot) {
  return {robot.base.speed_mps, robot.base.turn_radps, JointValues(robot, &ArmJoint::speed_radps)};
}

Edge::Edge(const Configuration& a, const Configuration& b, const EdgeSpeeds& speeds)
    : a_(a), joints_(b.tail<kArmJoints>() - a.tail<kArmJoints>()) {
  const Eigen::Vector2d way = b.head<2>() - a.head<2>();
  const double length_m = std::sqrt(way.squaredNorm());
  if (length_m < kSamePlace_m) {
    shift_m_ = way;
    turn1_rad_ = WrapAngle(b(2) - a(2));
    heading_rad_ = a(2) + turn1_rad_;
  } else {
    const double forwards_rad = std::atan2(way.y(), way.x());
    double least_rad = 1e9;
    for (const double sign : {1.0, -1.0}) {
      const double nose_rad = sign > 0 ? forwards_rad : forwards_rad + std::numbers::pi;
      const double turn1_rad = WrapAngle(nose_rad - a(2));
      const double turn2_rad = WrapAngle(b(2) - nose_rad);
      const double turn_rad = std::abs(turn1_rad) + std::abs(turn2_rad);
      if (turn_rad < least_rad - 1e-9) {
        least_rad = turn_rad;
        turn1_rad_ = turn1_rad;
        turn2_rad_ = turn2_rad;
        drive_m_ = sign * length_m;
      }
    }
    heading_rad_ = a(2) + turn1_rad_;
  }
  const double turn1_s = std::abs(turn1_rad_) / speeds.turn_radps;
  const double drive_s = std::abs(drive_m_) / speeds.drive_mps;
  const double base_s = turn1_s + drive_s + std::abs(turn2_rad_) / speeds.turn_radps;
  s_turned_ = base_s > 0 ? turn1_s / base_s : 0;
  s_driven_ = base_s > 0 ? (turn1_s + drive_s) / base_s : 1;
  duration_s_ = std::max(base_s, joints_.cwiseAbs().cwiseQuotient(speeds.joint_radps).maxCoeff());
}

Configuration Edge::At(double s) const {
  s = std::clamp(s, 0.0, 1.0);
  const double drive_m = drive_m_ * Share(s, s_turned_, s_driven_);
  Configuration q = a_;
  q(0) += drive_m * std::cos(heading_rad_) + s * shift_m_.x();
  q(1) += drive_m * std::sin(heading_rad_) + s * shift_m_.y();
  q(2) += turn1_rad_ * Share(s, 0, s_turned_) + turn2_rad_ * Share(s, s_driven_, 1);
  q.tail<kArmJoints>() += s * joints_;
  return q;
}

Controls Edge::RateAt(double s) const {
  Controls rate = Controls::Zero();
  if (s < s_turned_) {
    rate(1) = turn1_rad_ / s_turned_;
  } else if (s < s_driven_) {
    rate(0) = drive_m_ / (s_driven_ - s_turned_);
  } else if (s_driven_ < 1) {
    rate(1) = turn2_rad_ / (1 - s_driven_);
  }
  rate.tail<kArmJoints>() = joints_;
  return rate;
}

int Edge::Steps(double drive_step_m, double turn_step_rad) const {
  constexpr int kMost = 100000;
  double steps = joints_rad() / turn_step_rad;
  if (s_turned_ > 0) {
    steps = std::max(steps, std::abs(turn1_rad_) / s_turned_ / turn_step_rad);
  }
  if (s_driven_ > s_turned_) {
    steps = std::max(steps, std::abs(drive_m_) / (s_driven_ - s_turned_) / drive_step_m);
  }
  if (s_driven_ < 1) {
    steps = std::max(steps, std::abs(turn2_rad_) / (1 - s_driven_) / turn_step_rad);
  }
  return static_cast<int>(std::clamp(std::ceil(steps), 1.0, 1.0 * kMost));
}

Configuration EdgeAt(const Configuration& a, const Configuration& b, double s) {
  return Edge(a, b, SpeedsOf(TracerUf7())).At(s);
}

}  // namespace pipewright
