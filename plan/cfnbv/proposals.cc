// SPDX-License-Identifier: MIT
#include "plan/cfnbv/proposals.h"

#include <algorithm>
#include <numbers>

#include "perception/map/distance_field.h"
#include "perception/map/voxel_grid.h"
#include "plan/motion/inverse_kinematics.h"
#include "platform/robot/kinematics.h"
#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

constexpr double kNearJointsSigma_rad = 0.8;
constexpr double kNearWristSigma_rad = 1.2;
constexpr int kFirstWristJoint = 4;
constexpr double kNearTurnSigma_rad = 0.6;
constexpr double kNearDriveSigma_m = 0.3;
constexpr double kToolRoom_m = 0.07;  ///< an aimed sensor keeps at least this to obstacles
constexpr double kBaseReach_m = 0.8;  ///< the base is tried this far around a target
constexpr double kJointMargin_rad = 0.05;
constexpr int kStandpointDraws = 8;
constexpr double kHoldBaseShare = 0.4;    ///< of the aimed draws
constexpr double kOtherStandShare = 0.4;  ///< of those that may move the base
constexpr double kSurfaceShare = 0.5;     ///< patches beside uncovered voxels
constexpr double kCameraSpread = 0.1;     ///< of the axis about the target, rad
constexpr double kProbeSpread = 0.5;      ///< the probe sees all around
constexpr double kFacingSpread = 0.8;

/// Aimed at a surface the probe must be within its radius; P lies 45 mm beside S.
constexpr double kProbeDistanceMin_m = 0.15;
constexpr double kProbeDistanceMax_m = 0.34;
constexpr double kCameraDistanceMin_m = 0.30;
constexpr double kCameraDistanceMax_m = 1.20;

}  // namespace

Viewpoint ViewpointOf(const Configuration& q) {
  const Kinematics<kArmJoints> robot(TracerUf7(), q);
  return {robot.X_WS(), robot.p_WP()};
}

Vector3d Proposer::RandomVector() {
  const double x = rng_.Normal();
  const double y = rng_.Normal();
  return {x, y, rng_.Normal()};
}

Configuration Proposer::WithJointNoise(Configuration q, double sigma_rad, int first) {
  for (int i = first; i < kArmJoints; ++i) {
    const ArmJoint& joint = TracerUf7().arm.joints[i];
    q(3 + i) = std::clamp(q(3 + i) + sigma_rad * rng_.Normal(), joint.q_min_rad + kJointMargin_rad,
                          joint.q_max_rad - kJointMargin_rad);
  }
  return q;
}

/// A base pose about W, the arm folded or as it is.
Configuration Proposer::Somewhere() {
  const MapConfig& map = checker_.around().map.config();
  Configuration q = q_;
  q(0) = map.width_m * rng_.Uniform(map.lo.x, map.hi.x + 1);
  q(1) = map.width_m * rng_.Uniform(map.lo.y, map.hi.y + 1);
  q(2) = rng_.Uniform(-std::numbers::pi, std::numbers::pi);
  if (rng_.Uniform() < 0.5) {
    q.tail<kArmJoints>() = HomeJoints(TracerUf7());
  }
  return q;
}

/// Some of the wrist alone, which needs the least room, some of the arm, some of all.
std::optional<Configuration> Proposer::Near() {
  constexpr double kThird = 1.0 / 3;
  Configuration q = q_;
  const double what = rng_.Uniform();
  const double scale = rng_.Uniform(0.1, 1);
  if (what < kThird) {
    q = WithJointNoise(q, scale * kNearWristSigma_rad, kFirstWristJoint);
    return checker_.Free(q) ? std::optional(q) : std::nullopt;
  }
  if (what < 2 * kThird) {
    const double drive_m = scale * kNearDriveSigma_m * rng_.Normal();
    q(0) += drive_m * std::cos(q(2));
    q(1) += drive_m * std::sin(q(2));
    q(2) += scale * kNearTurnSigma_rad * rng_.Normal();
  }
  q = WithJointNoise(q, scale * kNearJointsSigma_rad);
  return checker_.Free(q) ? std::optional(q) : std::nullopt;
}

/// Base and joints anywhere: of what is hard to aim at, the most a microsecond.
std::optional<Configuration> Proposer::Far() {
  Configuration q = Somewhere();
  for (int i = 0; i < kArmJoints; ++i) {
    const ArmJoint& joint = TracerUf7().arm.joints[i];
    q(3 + i) = rng_.Uniform(std::max(joint.q_min_rad + kJointMargin_rad, -std::numbers::pi),
                            std::min(joint.q_max_rad - kJointMargin_rad, std::numbers::pi));
  }
  return checker_.Free(q) ? std::optional(q) : std::nullopt;
}

/// The tool would fit here.
bool Proposer::HasRoom(const Vector3d& p_W) const {
  const VoxelGrid& map = checker_.around().map;
  return !map.Obstacle(map.VoxelOf(p_W)) && checker_.around().field.Distance(p_W) >= kToolRoom_m;
}

/// A configuration with the sensor at from_W, looking towards at_W or about `spread` rad beside.
std::optional<Configuration> Proposer::Look(const Vector3d& from_W, const Vector3d& at_W,
                                            double spread) {
  const Vector3d toward = (at_W - from_W).normalized();
  const SensorTarget sensor{from_W, (toward + spread * RandomVector()).normalized()};
  const ReachConfig reach{.hold_base = rng_.Uniform() < kHoldBaseShare, .attempts = 2};
  Configuration seed = q_;
  if (!reach.hold_base && rng_.Uniform() < kOtherStandShare) {
    seed = Somewhere();
    seed(0) = from_W.x() + rng_.Uniform(-kBaseReach_m, kBaseReach_m);
    seed(1) = from_W.y() + rng_.Uniform(-kBaseReach_m, kBaseReach_m);
  }
  return Reach(checker_, sensor, seed, rng_, reach);
}

std::optional<Configuration> Proposer::AtFrontier() {
  const std::span<const VoxelIndex> frontier = gains_.Frontier();
  if (frontier.empty()) {
    return std::nullopt;
  }
  const VoxelIndex target = frontier[Pick(frontier.size())];
  const Vector3d center = checker_.around().map.Center(target);
  for (int i = 0; i < kStandpointDraws; ++i) {
    const double distance_m = rng_.Uniform(kCameraDistanceMin_m, kCameraDistanceMax_m);
    const Vector3d p_W = center + distance_m * RandomVector().normalized();
    if (HasRoom(p_W) && gains_.InSight(p_W, target)) {
      return Look(p_W, center, kCameraSpread);
    }
  }
  return std::nullopt;
}

std::optional<Configuration> Proposer::AtUncovered() {
  const std::span<const VoxelIndex> uncovered = gains_.Uncovered();
  if (uncovered.empty() || (!surface_.empty() && rng_.Uniform() < kSurfaceShare)) {
    return AtSurface();
  }
  const VoxelIndex target = uncovered[Pick(uncovered.size())];
  const Vector3d center = checker_.around().map.Center(target);
  for (int i = 0; i < kStandpointDraws; ++i) {
    const double distance_m = rng_.Uniform(kProbeDistanceMin_m, kProbeDistanceMax_m);
    const Vector3d p_W = center + distance_m * RandomVector().normalized();
    if (HasRoom(p_W) && gains_.InSight(p_W, target)) {
      return Look(p_W, center, kProbeSpread);
    }
  }
  return std::nullopt;
}

std::optional<Configuration> Proposer::AtSurface() {
  if (surface_.empty()) {
    return std::nullopt;
  }
  const SurfacePatch& patch = surface_[Pick(surface_.size())];
  for (int i = 0; i < kStandpointDraws; ++i) {
    const double distance_m = rng_.Uniform(kProbeDistanceMin_m, kProbeDistanceMax_m);
    const Vector3d away = (patch.n_W + kFacingSpread * RandomVector()).normalized();
    const Vector3d p_W = patch.p_W + distance_m * away;
    if (HasRoom(p_W) && gains_.SurfaceMet(p_W, patch)) {
      return Look(p_W, patch.p_W, kProbeSpread);
    }
  }
  return std::nullopt;
}

std::optional<Configuration> Proposer::Draw(CandidateKind kind) {
  switch (kind) {
    case CandidateKind::kNear:
      return Near();
    case CandidateKind::kFar:
      return Far();
    case CandidateKind::kUnknown:
      return AtFrontier();
    case CandidateKind::kUncovered:
      return AtUncovered();
    case CandidateKind::kUniform:
    case CandidateKind::kKept:
      return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace pipewright
