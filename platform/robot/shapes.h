// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "platform/core/fixed_vector.h"
#include "platform/core/frames.h"

namespace pipewright {

/// A ball that stands for a part of a body, for distances to the world.
struct BodySphere {
  int body = 0;
  Vector3d p_L = Vector3d::Zero();  ///< its centre in the body's frame
  double r_m = 0;
};

/// A disc of the base's footprint in the plane of B, for distances to what rises from the floor.
struct BaseDisc {
  Eigen::Vector2d p_B = Eigen::Vector2d::Zero();
  double r_m = 0;
};

/// A segment with a radius, for distances between parts of the robot.
struct BodyCapsule {
  int body = 0;
  Vector3d p_LA = Vector3d::Zero();  ///< the segment's ends
  Vector3d p_LB = Vector3d::Zero();
  double r_m = 0;
};

/// A convex shape of a body as built, for exact collision checks.
struct BodyShape {
  enum class Kind : std::uint8_t {
    kBox,       ///< half_m are its half edges along G's axes
    kCylinder,  ///< about z_G: radius half_m.x() (= half_m.y()), half length half_m.z()
  };

  int body = 0;
  Kind kind = Kind::kBox;
  Isometry3d X_LG = Isometry3d::Identity();  ///< pose of the shape's centre
  Vector3d half_m = Vector3d::Zero();
};

/// Two entries of a list that could touch within the joints' limits.
struct IndexPair {
  int first = 0;
  int second = 0;
};

/// The outline of a robot, in bodies of its Kinematics. spheres (with discs), capsules (with boxes)
/// and shapes are three views of the same bodies: each covers what is built to 5 mm.
struct RobotShapes {
  static constexpr int kMaxSpheres = 32;
  static constexpr int kMaxDiscs = 6;
  static constexpr int kMaxShapes = 24;
  static constexpr int kMaxPairs = 128;

  FixedVector<BodySphere, kMaxSpheres> spheres;  ///< arm and tool; the arm's foot is body 0
  FixedVector<BaseDisc, kMaxDiscs> discs;        ///< platform and pedestal, seen from above
  double discs_z_lo_m = 0;                       ///< and their heights in B
  double discs_z_hi_m = 0;
  FixedVector<BodyShape, kMaxShapes> shapes;
  FixedVector<BodyCapsule, kMaxShapes> capsules;  ///< arm and tool
  FixedVector<BodyShape, 4> boxes;                ///< platform and pedestal, axes along B's

  FixedVector<IndexPair, kMaxPairs> shape_pairs;    ///< (shape, shape)
  FixedVector<IndexPair, kMaxPairs> capsule_pairs;  ///< (capsule, capsule)
  FixedVector<IndexPair, kMaxPairs> box_pairs;      ///< (capsule, box)
};

/// The outline of TracerUf7(). Built at the first call; no heap.
const RobotShapes& TracerUf7Shapes();

}  // namespace pipewright
