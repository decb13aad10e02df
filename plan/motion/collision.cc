// SPDX-License-Identifier: MIT
#include "plan/motion/collision.h"

#include <algorithm>
#include <cmath>

#include "perception/map/distance_field.h"
#include "perception/plane_slab.h"
#include "plan/motion/edge.h"
#include "plan/motion/narrow_phase.h"
#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

constexpr double kFar_m = 1e3;
constexpr double kSphereSlip_m = 0.005;  // what RobotShapes lets its spheres leave uncovered

double SlabDistanceOf(const PlaneEstimate& plane, const Vector3d& p_W, const CollisionConfig& c) {
  return PointToSlab(p_W, plane, c.plane_border_m, c.plane_behind_m).d_m;
}

double PipeAxisDistance(const PipeEstimate& pipe, const Vector3d& p_W, const CollisionConfig& c) {
  const double foot_m = pipe.l_W.dot(p_W - pipe.p_W);
  const double s_m =
      std::clamp(foot_m, pipe.extent_lo_m - c.pipe_border_m, pipe.extent_hi_m + c.pipe_border_m);
  return std::sqrt((p_W - pipe.p_W - s_m * pipe.l_W).squaredNorm());
}

struct Segment {
  Vector3d p_WA;
  Vector3d p_WB;
};

}  // namespace

CollisionChecker::CollisionChecker(const Surroundings& around, const CollisionConfig& config)
    : around_(around), config_(config) {}

bool CollisionChecker::Free(const Configuration& q) const {
  if (!q.allFinite()) {
    return false;
  }
  const Body body(TracerUf7(), q);
  const double shapes_surely_free_m =
      config_.margin_m + kSphereSlip_m - config_.voxel_margin_m - config_.slack_m;
  bool ask_shapes = false;
  for (const Kind kind : kAllKinds) {
    const bool voxels = kind == kVoxels;
    const Range range{-relief_[kind], voxels ? shapes_surely_free_m : 0};
    const double spare = Spare(kind, q, body, range);
    if (spare < -relief_[kind]) {
      return false;
    }
    ask_shapes = ask_shapes || (voxels && spare < shapes_surely_free_m);
  }
  return !ask_shapes || !shapes_decide_ || ShapesFree(body, config_.margin_m);
}

double CollisionChecker::Clearance(const Configuration& q) const {
  const Body body(TracerUf7(), q);
  return std::min(ColumnSpare(body), VoxelSpare(body, {})) + config_.voxel_margin_m +
         config_.slack_m;
}

bool CollisionChecker::FreeEdge(const Configuration& a, const Configuration& b) const {
  constexpr double kDrive_m = 0.02;
  constexpr double kTurn_rad = 0.05;
  const Edge edge(a, b, SpeedsOf(TracerUf7()));
  const int steps = edge.Steps(kDrive_m, kTurn_rad);
  int stride = 1;
  while (2 * stride <= steps) {
    stride *= 2;
  }
  // The end first, then ever finer: what is blocked is found early.
  if (!Free(b)) {
    return false;
  }
  for (; stride >= 1; stride /= 2) {
    for (int i = stride; i < steps; i += 2 * stride) {
      if (!Free(edge.At(1.0 * i / steps))) {
        return false;
      }
    }
  }
  return true;
}

CollisionChecker CollisionChecker::RelaxedTo(const Configuration& q, double floor_m) const {
  constexpr double kRounding = 1e-4;
  CollisionChecker relaxed = *this;
  const Body body(TracerUf7(), q);
  for (const Kind kind : kAllKinds) {
    relaxed.relief_[kind] = std::max(0.0, -Spare(kind, q, body, {})) + kRounding;
  }
  constexpr int kSteps = 6;
  for (int i = 0; i <= kSteps; ++i) {
    relaxed.config_.margin_m = config_.margin_m + (floor_m - config_.margin_m) * i / kSteps;
    if (ShapesFree(body, relaxed.config_.margin_m)) {
      return relaxed;
    }
  }
  relaxed.shapes_decide_ = false;
  return relaxed;
}

/// How much more than required q has of a kind, the least over the body. [m; joints in rad]
double CollisionChecker::Spare(Kind kind, const Configuration& q, const Body& body,
                               const Range& range) const {
  switch (kind) {
    case kJoints:
      return JointSpare(q);
    case kColumns:
      return ColumnSpare(body);
    case kBasePlanes:
      return BasePlaneSpare(body);
    case kVoxels:
      return VoxelSpare(body, range);
    case kPlanes:
      return PlaneSpare(body);
    case kPipes:
      return PipeSpare(body);
    case kSelf:
      return SelfSpare(body, range);
  }
  return -kFar_m;
}

double CollisionChecker::JointSpare(const Configuration& q) const {
  double spare_rad = kFar_m;
  for (int i = 0; i < kArmJoints; ++i) {
    const ArmJoint& joint = TracerUf7().arm.joints[i];
    spare_rad = std::min({spare_rad, q(3 + i) - joint.q_min_rad, joint.q_max_rad - q(3 + i)});
  }
  return spare_rad - config_.joint_margin_rad;
}

double CollisionChecker::ColumnSpare(const Body& body) const {
  double spare_m = kFar_m;
  for (const BaseDisc& disc : TracerUf7Shapes().discs) {
    const Vector3d p_W = body.Point(Body::kBase, {disc.p_B.x(), disc.p_B.y(), 0});
    const Nearest nearest = around_.field.NearestColumn(p_W.x(), p_W.y());
    spare_m = std::min(spare_m, nearest.distance_m - disc.r_m);
  }
  return spare_m - config_.voxel_margin_m - config_.slack_m;
}

double CollisionChecker::BasePlaneSpare(const Body& body) const {
  constexpr double kMidHeight_m = 0.1;  // of the platform
  const Vector3d p_W = body.Point(Body::kBase, {0, 0, kMidHeight_m});
  double spare_m = kFar_m;
  for (const PlaneEstimate& plane : around_.scene.planes) {
    if (std::abs(plane.n_W.z()) < config_.upright_nz) {
      spare_m = std::min(spare_m, SlabDistanceOf(plane, p_W, config_));
    }
  }
  return spare_m - config_.base_plane_m - config_.slack_m;
}

double CollisionChecker::VoxelSpare(const Body& body, const Range& range) const {
  const double required_m = config_.voxel_margin_m + config_.slack_m;
  double spare_m = kFar_m;
  for (const BodySphere& sphere : TracerUf7Shapes().spheres) {
    const Vector3d p_W = body.Point(sphere.body, sphere.p_L);
    const double at_least_m = around_.field.DistanceAtLeast(p_W) - sphere.r_m - required_m;
    if (at_least_m < std::min(spare_m, range.enough)) {
      spare_m = std::min(spare_m, around_.field.Distance(p_W) - sphere.r_m - required_m);
      if (spare_m < range.too_little) {
        return spare_m;
      }
    }
  }
  return spare_m;
}

double CollisionChecker::PlaneSpare(const Body& body) const {
  double spare_m = kFar_m;
  for (const BodySphere& sphere : TracerUf7Shapes().spheres) {
    const Vector3d p_W = body.Point(sphere.body, sphere.p_L);
    const double required_m =
        std::max(config_.plane_m, sphere.r_m + config_.primitive_margin_m) + config_.slack_m;
    for (const PlaneEstimate& plane : around_.scene.planes) {
      spare_m = std::min(spare_m, SlabDistanceOf(plane, p_W, config_) - required_m);
    }
  }
  return spare_m;
}

double CollisionChecker::PipeSpare(const Body& body) const {
  double spare_m = kFar_m;
  for (const BodySphere& sphere : TracerUf7Shapes().spheres) {
    const Vector3d p_W = body.Point(sphere.body, sphere.p_L);
    const double required_m =
        std::max(config_.pipe_m, sphere.r_m + config_.primitive_margin_m) + config_.slack_m;
    for (const PipeEstimate& pipe : around_.scene.pipes) {
      spare_m =
          std::min(spare_m, PipeAxisDistance(pipe, p_W, config_) - pipe.radius_m - required_m);
    }
  }
  return spare_m;
}

double CollisionChecker::SelfSpare(const Body& body, const Range& range) const {
  const RobotShapes& robot = TracerUf7Shapes();
  const double required_m = config_.self_m + config_.slack_m;
  FixedVector<Segment, RobotShapes::kMaxShapes> segments;
  for (const BodyCapsule& capsule : robot.capsules) {
    static_cast<void>(segments.push_back(
        {body.Point(capsule.body, capsule.p_LA), body.Point(capsule.body, capsule.p_LB)}));
  }
  double spare_m = kFar_m;
  for (const IndexPair& pair : robot.capsule_pairs) {
    const Segment& a = segments[pair.first];
    const Segment& b = segments[pair.second];
    const double radii_m = robot.capsules[pair.first].r_m + robot.capsules[pair.second].r_m;
    const double apart_m = std::sqrt((a.p_WA - b.p_WA).squaredNorm()) -
                           std::sqrt((a.p_WB - a.p_WA).squaredNorm()) -
                           std::sqrt((b.p_WB - b.p_WA).squaredNorm());
    if (apart_m - radii_m - required_m < std::min(spare_m, range.enough)) {
      spare_m =
          std::min(spare_m, SegmentDistance(a.p_WA, a.p_WB, b.p_WA, b.p_WB) - radii_m - required_m);
    }
  }
  for (const IndexPair& pair : robot.box_pairs) {
    const Segment& a = segments[pair.first];
    const BodyShape& box = robot.boxes[pair.second];
    const Isometry3d X_GW = (body.X_WL(box.body) * box.X_LG).inverse();
    const Vector3d p_GA = X_GW * a.p_WA;
    const Vector3d p_GB = X_GW * a.p_WB;
    const double less_m = robot.capsules[pair.first].r_m + required_m;
    const double apart_m = std::max((p_GA.cwiseMin(p_GB) - box.half_m).maxCoeff(),
                                    (-p_GA.cwiseMax(p_GB) - box.half_m).maxCoeff());
    if (apart_m - less_m < std::min(spare_m, range.enough)) {
      spare_m = std::min(spare_m, SegmentBoxDistance(p_GA, p_GB, box.half_m) - less_m);
    }
  }
  return spare_m;
}

bool CollisionChecker::ShapesFree(const Body& body, double margin_m) const {
  std::array<bool, Body::kBodies> near{};
  for (const BodySphere& sphere : TracerUf7Shapes().spheres) {
    const Vector3d p_W = body.Point(sphere.body, sphere.p_L);
    near[sphere.body] =
        near[sphere.body] || around_.field.Distance(p_W) - sphere.r_m < margin_m + kSphereSlip_m;
  }
  for (const BodyShape& shape : TracerUf7Shapes().shapes) {
    const bool chassis = shape.body == Body::kBase && shape.kind == BodyShape::Kind::kBox;
    if (near[shape.body] && !chassis &&
        MeetsObstacle(shape, body.X_WL(shape.body) * shape.X_LG, margin_m, around_.map)) {
      return false;
    }
  }
  return true;
}

}  // namespace pipewright
