// SPDX-License-Identifier: MIT
#include "platform/robot/shapes.h"

#include <cassert>
#include <cmath>

#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

constexpr double kHalf = std::numbers::pi / 2;
constexpr double kQuarter = std::numbers::pi / 4;

/// A cylinder about z after Rz(yaw) Ry(pitch) Rx(roll), by its centre.
struct CylinderRow {
  int body;
  double x_m, y_m, z_m;
  double roll_rad, pitch_rad;
  double r_m, length_m;
};

struct BoxRow {
  int body;
  double x_m, y_m, z_m;
  double length_m, width_m, height_m;
};

struct SphereRow {
  int body;
  double x_m, y_m, z_m;
  double r_m;
};

// The arm as built: each link's runs, read off the extents of the vendor's collision meshes. Links
// 2, 4 and the end of 5 hang on the side of the joint before them and slant back to the middle line
// through a neck.
// clang-format off
constexpr CylinderRow kCylinders[] = {
    //     x        y        z        roll        pitch       r        length
    {0,  0.10,    0,       0.355,    0,          0,          0.063,   0.150},   // foot of the arm
    {1,  0,       0,      -0.058,    0,          0,          0.048,   0.116},   // tube
    {1,  0,       0.001,   0,        kHalf,      0,          0.048,   0.116},   // hub of joint 2
    {2,  0,       0,       0.0885,   0,          0,          0.048,   0.059},   // hub of joint 2
    {2,  0,      -0.050,   0.044,   -kQuarter,   0,          0.040,   0.1245},  // neck
    {2,  0,      -0.1215,  0,        kHalf,      0,          0.044,   0.123},   // tube
    {3,  0,       0,      -0.040,    0,          0,          0.045,   0.140},   // tube
    {3,  0.0525,  0.0115,  0,        kHalf,      0,          0.0445,  0.115},   // hub of joint 4
    {4,  0,       0,       0.0775,   0,          0,          0.044,   0.063},   // hub of joint 4
    {4,  0.039,  -0.055,   0.039,   -kQuarter,  -kQuarter,   0.036,   0.156},   // neck
    {4,  0.0775, -0.116,   0,        kHalf,      0,          0.045,   0.092},   // tube
    {5,  0,       0,      -0.116,    0,          0,          0.045,   0.132},   // tube
    {5,  0,       0.031,  -0.031,   -kQuarter,   0,          0.034,   0.0877},  // neck
    {5,  0,       0.0625,  0,        kHalf,      0,          0.038,   0.047},   // cheek of joint 6
    {6,  0,       0,       0.0105,   0,          0,          0.039,   0.099},   // hub of joint 6
    {7,  0,       0,      -0.0155,   0,          0,          0.039,   0.031},   // flange
    {8,  0,       0.045,   0.025,    0,          0,          0.012,   0.050},   // probe
};

constexpr BoxRow kBoxes[] = {
    //     x        y        z         along x  y        z
    {0,  0,       0,       0.0995,    0.700,   0.500,   0.127},   // platform
    {0,  0.10,    0,       0.2215,    0.260,   0.260,   0.117},   // pedestal
    {6,  0.0575,  0.0145,  0,         0.115,   0.105,   0.078},   // block of joint 7
    {7,  0,      -0.045,  -0.0155,    0.040,   0.020,   0.031},   // connector
    {8,  0,       0.0185,  0.00775,   0.040,   0.077,   0.0155},  // bracket
    {8,  0,       0,       0.030,     0.124,   0.026,   0.029},   // camera
};

// Fitted to points of the shapes above (least sum of volumes), then about 3 mm smaller.
constexpr SphereRow kSpheres[] = {
    //     x        y        z        r
    {0,  0.10,    0,       0.317,   0.072},
    {0,  0.10,    0,       0.399,   0.069},
    {1,  0,       0,      -0.077,   0.060},
    {1,  0,      -0.018,   0,       0.060},
    {1,  0,       0.038,   0,       0.049},
    {2,  0,       0,       0.088,   0.053},
    {2,  0,      -0.051,   0.049,   0.047},
    {2,  0,      -0.083,   0,       0.047},
    {2,  0,      -0.147,   0,       0.054},
    {3,  0,       0,      -0.075,   0.054},
    {3, -0.010,  -0.003,  -0.002,   0.053},
    {3,  0.053,   0.011,   0,       0.069},
    {4,  0,       0,       0.078,   0.051},
    {4,  0.042,  -0.060,   0.036,   0.049},
    {4,  0.078,  -0.097,   0,       0.049},
    {4,  0.078,  -0.147,   0,       0.045},
    {5,  0,       0,      -0.144,   0.058},
    {5,  0,       0,      -0.062,   0.054},
    {5,  0,       0.060,  -0.002,   0.046},
    {6,  0.002,  -0.002,   0.046,   0.041},
    {6,  0.007,   0.015,  -0.001,   0.065},
    {6,  0.075,   0.015,   0,       0.073},
    {7,  0,      -0.010,  -0.016,   0.048},
    {8,  0.031,  -0.001,   0.023,   0.037},
    {8, -0.030,  -0.001,   0.021,   0.038},
    {8,  0,       0.045,   0.021,   0.029},
};
// clang-format on

/// Bodies that touch in no posture within the limits are not compared; neighbours never are.
struct BodyPair {
  int first;
  int second;
};
constexpr BodyPair kBodyPairs[] = {
    {0, 4}, {0, 5}, {0, 6}, {0, 7}, {0, 8},  //
    {1, 5}, {1, 6}, {1, 7}, {1, 8},          //
    {2, 5}, {2, 6}, {2, 7}, {2, 8},          //
    {5, 7}, {5, 8},
};

/// The shape's longest axis with the radius of its cross-section, cut back at both ends as far as
/// the rim stays within kCover of the round end.
BodyCapsule CapsuleOf(const BodyShape& shape) {
  constexpr double kCover = 0.004;
  int longest = 2;
  double r = shape.half_m.x();
  if (shape.kind == BodyShape::Kind::kBox) {
    shape.half_m.maxCoeff(&longest);
    Vector3d across = shape.half_m;
    across(longest) = 0;
    r = across.norm();
  }
  const double cut = std::sqrt((r + kCover) * (r + kCover) - r * r);
  Vector3d p_GB = Vector3d::Zero();
  p_GB(longest) = std::max(0.0, shape.half_m(longest) - cut);
  return {shape.body, shape.X_LG * Vector3d(-p_GB), shape.X_LG * p_GB, r};
}

BodyShape ShapeOf(const CylinderRow& row) {
  BodyShape shape{.body = row.body, .kind = BodyShape::Kind::kCylinder};
  shape.X_LG.linear() = (Eigen::AngleAxisd(row.pitch_rad, Vector3d::UnitY()) *
                         Eigen::AngleAxisd(row.roll_rad, Vector3d::UnitX()))
                            .toRotationMatrix();
  shape.X_LG.translation() = Vector3d{row.x_m, row.y_m, row.z_m};
  shape.half_m = Vector3d{row.r_m, row.r_m, row.length_m / 2};
  return shape;
}

BodyShape ShapeOf(const BoxRow& row) {
  BodyShape shape{.body = row.body, .kind = BodyShape::Kind::kBox};
  shape.X_LG.translation() = Vector3d{row.x_m, row.y_m, row.z_m};
  shape.half_m = Vector3d{row.length_m, row.width_m, row.height_m} / 2;
  return shape;
}

bool Compared(int a, int b) {
  for (const BodyPair& pair : kBodyPairs) {
    if ((pair.first == a && pair.second == b) || (pair.first == b && pair.second == a)) {
      return true;
    }
  }
  return false;
}

template <typename A, int kA, typename B, int kB>
void AddPairs(const FixedVector<A, kA>& firsts, const FixedVector<B, kB>& seconds, bool same_list,
              FixedVector<IndexPair, RobotShapes::kMaxPairs>& pairs) {
  for (int i = 0; i < firsts.size(); ++i) {
    for (int j = same_list ? i + 1 : 0; j < seconds.size(); ++j) {
      if (Compared(firsts[i].body, seconds[j].body)) {
        const bool added = pairs.push_back({i, j});
        assert(added);
        static_cast<void>(added);
      }
    }
  }
}

template <typename T, int kCapacity>
void Add(const T& value, FixedVector<T, kCapacity>& list) {
  const bool added = list.push_back(value);
  assert(added);
  static_cast<void>(added);
}

/// Discs in three columns and two rows that cover the footprint's rectangle with its corners. One
/// row of larger discs would reach 0.16 m beyond the bumpers, this one 0.05 m.
void AddDiscs(const TracerModel& base, RobotShapes& robot) {
  constexpr int kColumns = 3;
  constexpr int kRows = 2;
  const double half_x_m = base.length_m / (2 * kColumns);
  const double half_y_m = base.width_m / (2 * kRows);
  const double r_m = std::sqrt(half_x_m * half_x_m + half_y_m * half_y_m);
  for (int i = 0; i < kColumns; ++i) {
    for (int j = 0; j < kRows; ++j) {
      const Eigen::Vector2d p_B{(2 * i - (kColumns - 1)) * half_x_m,
                                (2 * j - (kRows - 1)) * half_y_m};
      Add(BaseDisc{p_B, r_m}, robot.discs);
    }
  }
}

RobotShapes Build() {
  RobotShapes robot;
  for (const CylinderRow& row : kCylinders) {
    Add(ShapeOf(row), robot.shapes);
    Add(CapsuleOf(robot.shapes.back()), robot.capsules);
  }
  for (const BoxRow& row : kBoxes) {
    Add(ShapeOf(row), robot.shapes);
    if (row.body == 0) {
      Add(robot.shapes.back(), robot.boxes);
    } else {
      Add(CapsuleOf(robot.shapes.back()), robot.capsules);
    }
  }
  for (const SphereRow& row : kSpheres) {
    Add(BodySphere{row.body, {row.x_m, row.y_m, row.z_m}, row.r_m}, robot.spheres);
  }
  AddDiscs(kTracerUf7.base, robot);
  robot.discs_z_lo_m = kTracerUf7.base.clearance_m;
  robot.discs_z_hi_m = kTracerUf7.mount.p_BA_m[2];
  AddPairs(robot.shapes, robot.shapes, true, robot.shape_pairs);
  AddPairs(robot.capsules, robot.capsules, true, robot.capsule_pairs);
  AddPairs(robot.capsules, robot.boxes, false, robot.box_pairs);
  return robot;
}

}  // namespace

const RobotShapes& TracerUf7Shapes() {
  static const RobotShapes robot = Build();
  return robot;
}

}  // namespace pipewright
