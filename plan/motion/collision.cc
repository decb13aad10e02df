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

/// At most SlabDistanceOf: how far the point is beyond the one face it is farthest beyond.
double SlabDistanceAtLeast(const PlaneEstimate& plane, const Vector3d& p_W,
                           const CollisionConfig& c) {
  const Vector3d p_CT_W = p_W - plane.p_WCentroid;
  const double s1_m = plane.e1_W.dot(p_CT_W);
  const double s2_m = plane.e2_W.dot(p_CT_W);
  const double beside_m = std::max({s1_m - plane.extent_hi_m[0], plane.extent_lo_m[0] - s1_m,
                                    s2_m - plane.extent_hi_m[1], plane.extent_lo_m[1] - s2_m});
  const double before_m = plane.n_W.dot(p_W) - plane.d_m;
  return std::max(before_m, beside_m - c.plane_border_m);
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
  Vector3d p_WMiddle;
  double half_m = 0;
};

Segment SegmentBetween(const Vector3d& p_WA, const Vector3d& p_WB) {
  return {p_WA, p_WB, (p_WA + p_WB) / 2, std::sqrt((p_WB - p_WA).squaredNorm()) / 2};
}

double Squared(double x) { return x * x; }

}  // namespace

CollisionChecker::Posture::Posture(const Configuration& q) : body(TracerUf7(), q) {
  const auto& spheres = TracerUf7Shapes().spheres;
  for (int i = 0; i < spheres.size(); ++i) {
    p_WSpheres[i] = body.Point(spheres[i].body, spheres[i].p_L);
    p_WMiddle += p_WSpheres[i] / spheres.size();
  }
  double reach_m2 = 0;
  for (int i = 0; i < spheres.size(); ++i) {
    reach_m2 = std::max(reach_m2, (p_WSpheres[i] - p_WMiddle).squaredNorm());
    largest_r_m = std::max(largest_r_m, spheres[i].r_m);
  }
  reach_m = std::sqrt(reach_m2);
}

CollisionChecker::CollisionChecker(const Surroundings& around, const CollisionConfig& config)
    : around_(around), config_(config) {}

bool CollisionChecker::Free(const Configuration& q) const {
  if (!q.allFinite()) {
    return false;
  }
  const Posture posture(q);
  const double shapes_surely_free_m =
      config_.margin_m + kSphereSlip_m - config_.voxel_margin_m - config_.slack_m;
  bool ask_shapes = false;
  for (const Kind kind : kAllKinds) {
    const bool voxels = kind == kVoxels;
    const Range range{-relief_[kind], voxels ? shapes_surely_free_m : 0};
    const double spare = Spare(kind, q, posture, range);
    if (spare < -relief_[kind]) {
      return false;
    }
    ask_shapes = ask_shapes || (voxels && spare < shapes_surely_free_m);
  }
  return !ask_shapes || !shapes_decide_ || ShapesFree(posture, config_.margin_m);
}

double CollisionChecker::Clearance(const Configuration& q) const {
  const Posture posture(q);
  return std::min(ColumnSpare(posture.body), VoxelSpare(posture, {})) + config_.voxel_margin_m +
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
  const Posture posture(q);
  for (const Kind kind : kAllKinds) {
    relaxed.relief_[kind] = std::max(0.0, -Spare(kind, q, posture, {})) + kRounding;
  }
  constexpr int kSteps = 6;
  for (int i = 0; i <= kSteps; ++i) {
    relaxed.config_.margin_m = config_.margin_m + (floor_m - config_.margin_m) * i / kSteps;
    if (ShapesFree(posture, relaxed.config_.margin_m)) {
      return relaxed;
    }
  }
  relaxed.shapes_decide_ = false;
  return relaxed;
}

/// How much more than required q has of a kind, the least over the body. [m; joints in rad]
double CollisionChecker::Spare(Kind kind, const Configuration& q, const Posture& posture,
                               const Range& range) const {
  switch (kind) {
    case kJoints:
      return JointSpare(q);
    case kColumns:
      return ColumnSpare(posture.body);
    case kBasePlanes:
      return BasePlaneSpare(posture.body);
    case kVoxels:
      return VoxelSpare(posture, range);
    case kPlanes:
      return PlaneSpare(posture, range);
    case kPipes:
      return PipeSpare(posture, range);
    case kSelf:
      return SelfSpare(posture.body, range);
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

double CollisionChecker::VoxelSpare(const Posture& posture, const Range& range) const {
  const auto& spheres = TracerUf7Shapes().spheres;
  const double required_m = config_.voxel_margin_m + config_.slack_m;
  double spare_m = kFar_m;
  for (int i = 0; i < spheres.size(); ++i) {
    const Vector3d& p_W = posture.p_WSpheres[i];
    const double less_m = spheres[i].r_m + required_m;
    if (around_.field.DistanceAtLeast(p_W) - less_m < std::min(spare_m, range.enough)) {
      spare_m = std::min(spare_m, around_.field.Distance(p_W) - less_m);
      if (spare_m < range.too_little) {
        return spare_m;
      }
    }
  }
  return spare_m;
}

double CollisionChecker::PlaneSpare(const Posture& posture, const Range& range) const {
  const auto& spheres = TracerUf7Shapes().spheres;
  const auto required_m = [&](double r_m) {
    return std::max(config_.plane_m, r_m + config_.primitive_margin_m) + config_.slack_m;
  };
  double spare_m = kFar_m;
  for (const PlaneEstimate& plane : around_.scene.planes) {
    const auto matters = [&](const Vector3d& p_W, double less_m) {
      return SlabDistanceAtLeast(plane, p_W, config_) - less_m < std::min(spare_m, range.enough);
    };
    if (!matters(posture.p_WMiddle, posture.reach_m + required_m(posture.largest_r_m))) {
      continue;
    }
    for (int i = 0; i < spheres.size(); ++i) {
      const Vector3d& p_W = posture.p_WSpheres[i];
      const double less_m = required_m(spheres[i].r_m);
      if (matters(p_W, less_m)) {
        spare_m = std::min(spare_m, SlabDistanceOf(plane, p_W, config_) - less_m);
      }
    }
    if (spare_m < range.too_little) {
      return spare_m;
    }
  }
  return spare_m;
}

double CollisionChecker::PipeSpare(const Posture& posture, const Range& range) const {
  const auto& spheres = TracerUf7Shapes().spheres;
  const auto required_m = [&](double r_m) {
    return std::max(config_.pipe_m, r_m + config_.primitive_margin_m) + config_.slack_m;
  };
  double spare_m = kFar_m;
  for (const PipeEstimate& pipe : around_.scene.pipes) {
    const auto spare_at_m = [&](const Vector3d& p_W, double less_m) {
      return PipeAxisDistance(pipe, p_W, config_) - pipe.radius_m - less_m;
    };
    if (spare_at_m(posture.p_WMiddle, posture.reach_m + required_m(posture.largest_r_m)) >=
        std::min(spare_m, range.enough)) {
      continue;
    }
    for (int i = 0; i < spheres.size(); ++i) {
      spare_m = std::min(spare_m, spare_at_m(posture.p_WSpheres[i], required_m(spheres[i].r_m)));
    }
    if (spare_m < range.too_little) {
      return spare_m;
    }
  }
  return spare_m;
}

double CollisionChecker::SelfSpare(const Body& body, const Range& range) const {
  const RobotShapes& robot = TracerUf7Shapes();
  const double required_m = config_.self_m + config_.slack_m;
  FixedVector<Segment, RobotShapes::kMaxShapes> segments;
  for (const BodyCapsule& capsule : robot.capsules) {
    static_cast<void>(segments.push_back(SegmentBetween(body.Point(capsule.body, capsule.p_LA),
                                                        body.Point(capsule.body, capsule.p_LB))));
  }
  double spare_m = kFar_m;
  for (const IndexPair& pair : robot.capsule_pairs) {
    const Segment& a = segments[pair.first];
    const Segment& b = segments[pair.second];
    const double less_m =
        robot.capsules[pair.first].r_m + robot.capsules[pair.second].r_m + required_m;
    const double matters_m = a.half_m + b.half_m + less_m + std::min(spare_m, range.enough);
    if (matters_m > 0 && (a.p_WMiddle - b.p_WMiddle).squaredNorm() < Squared(matters_m)) {
      spare_m = std::min(spare_m, SegmentDistance(a.p_WA, a.p_WB, b.p_WA, b.p_WB) - less_m);
      if (spare_m < range.too_little) {
        return spare_m;
      }
    }
  }
  FixedVector<Isometry3d, decltype(robot.boxes)::capacity()> X_GW;
  for (const BodyShape& box : robot.boxes) {
    static_cast<void>(X_GW.push_back((body.X_WL(box.body) * box.X_LG).inverse()));
  }
  for (const IndexPair& pair : robot.box_pairs) {
    const Segment& a = segments[pair.first];
    const BodyShape& box = robot.boxes[pair.second];
    const double less_m = robot.capsules[pair.first].r_m + required_m;
    const Vector3d p_GA = X_GW[pair.second] * a.p_WA;
    const Vector3d p_GB = X_GW[pair.second] * a.p_WB;
    const double apart_m = std::max((p_GA.cwiseMin(p_GB) - box.half_m).maxCoeff(),
                                    (-p_GA.cwiseMax(p_GB) - box.half_m).maxCoeff());
    if (apart_m - less_m < std::min(spare_m, range.enough)) {
      spare_m = std::min(spare_m, SegmentBoxDistance(p_GA, p_GB, box.half_m) - less_m);
    }
  }
  return spare_m;
}

bool CollisionChecker::ShapesFree(const Posture& posture, double margin_m) const {
  const auto& spheres = TracerUf7Shapes().spheres;
  std::array<bool, Body::kBodies> near{};
  for (int i = 0; i < spheres.size(); ++i) {
    bool& body_near = near[spheres[i].body];
    body_near = body_near || around_.field.Distance(posture.p_WSpheres[i]) - spheres[i].r_m <
                                 margin_m + kSphereSlip_m;
  }
  for (const BodyShape& shape : TracerUf7Shapes().shapes) {
    const bool chassis = shape.body == Body::kBase && shape.kind == BodyShape::Kind::kBox;
    if (near[shape.body] && !chassis &&
        MeetsObstacle(shape, posture.body.X_WL(shape.body) * shape.X_LG, margin_m, around_.map)) {
      return false;
    }
  }
  return true;
}

}  // namespace pipewright
