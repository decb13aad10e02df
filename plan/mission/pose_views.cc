// SPDX-License-Identifier: MIT
#include "plan/mission/pose_views.h"

#include <Eigen/LU>
#include <algorithm>
#include <numbers>
#include <utility>

#include "perception/map/distance_field.h"
#include "plan/cfnbv/open_rays.h"
#include "plan/cfnbv/proposals.h"
#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

constexpr int kFirstWristJoint = 4;
constexpr double kJointMargin_rad = 0.05;

ArmVector Draw(const ArmVector& posture, bool wrist_alone, Rng& rng) {
  ArmVector drawn = posture;
  for (int j = wrist_alone ? kFirstWristJoint : 0; j < kArmJoints; ++j) {
    const ArmJoint& joint = TracerUf7().arm.joints[j];
    drawn(j) = rng.Uniform(std::max(joint.q_min_rad + kJointMargin_rad, -std::numbers::pi),
                           std::min(joint.q_max_rad - kJointMargin_rad, std::numbers::pi));
  }
  return drawn;
}

}  // namespace

Mat<3, 3> PoseViews::Information(const Configuration& q, const Surroundings& around,
                                 const RaySet& camera) {
  const Isometry3d X_WS = ViewpointOf(q).X_WS;
  OpenRays(q, camera, open_);
  const int rays = open_.directions.size();
  for (int i = 0; i < rays; ++i) {
    directions_W_[i] = (X_WS.linear() * open_.directions[i]).cast<float>();
  }
  around.map.CastRays(X_WS.translation().cast<float>(), directions_W_.data(), rays, config_.range_m,
                      false, hits_.data());
  const double width_m = around.map.config().width_m;
  Mat<3, 3> information = Mat<3, 3>::Zero();
  for (int i = 0; i < rays; ++i) {
    if (!hits_[i].hit) {
      continue;
    }
    const Vector3d toward = directions_W_[i].cast<double>();
    const Vector3d p_WQ = around.map.Center(hits_[i].end);
    const Vector3d n = around.field.Interpolate(p_WQ - width_m * toward).gradient_W.normalized();
    if (-n.dot(toward) < config_.cosine_min || n.head<2>().norm() < config_.upright_min) {
      continue;
    }
    const Vector3d J(n.x(), n.y(), n.y() * (p_WQ.x() - q(0)) - n.x() * (p_WQ.y() - q(1)));
    information += J * J.transpose() / (config_.sigma_m * config_.sigma_m);
  }
  return information;
}

double PoseViews::VarianceAfter(const Configuration& q, const Surroundings& around,
                                const RaySet& camera) {
  const double place = 1 / (config_.before_m * config_.before_m);
  const double heading = 1 / (config_.before_rad * config_.before_rad);
  Mat<3, 3> information = Information(q, around, camera);
  information.diagonal() += Vector3d(place, place, heading);
  return information.inverse().trace();
}

void PoseViews::Find(const CollisionChecker& checker, const Configuration& q, const RaySet& camera,
                     Rng& rng, Views& best) {
  struct Scored {
    double variance_m2;
    ArmVector posture;
  };
  FixedVector<Scored, kMost + 1> found;
  for (int i = 0; i < config_.draws; ++i) {
    Configuration at = q;
    at.tail<kArmJoints>() = Draw(q.tail<kArmJoints>(), i % 2 == 0, rng);
    if (!checker.Free(at)) {
      continue;
    }
    const Scored scored{VarianceAfter(at, checker.around(), camera), at.tail<kArmJoints>()};
    static_cast<void>(found.push_back(scored));
    for (int k = found.size() - 1; k > 0 && found[k].variance_m2 < found[k - 1].variance_m2; --k) {
      std::swap(found[k], found[k - 1]);
    }
    if (found.size() > kMost) {
      found.pop_back();
    }
  }
  best.clear();
  for (const Scored& scored : found) {
    static_cast<void>(best.push_back(scored.posture));
  }
}

}  // namespace pipewright
