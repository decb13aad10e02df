// SPDX-License-Identifier: MIT
#include "tests/timing/case_maker.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "platform/robot/kinematics.h"
#include "platform/robot/shapes.h"
#include "platform/robot/uf7.h"

namespace pipewright::timing {
namespace {

static_assert(Scene::kMaxPlanes == Scene::kMaxPipes);

constexpr double kMaxDeviation = 0.1;  ///< of a primitive's parameters, in m and 1

}  // namespace

Vector3d CaseMaker::Direction() {
  const Vector3d d{rng_.Normal(), rng_.Normal(), rng_.Normal()};
  return d.normalized();
}

double CaseMaker::Scale(double least, double most) {
  return std::exp(rng_.Uniform(std::log(least), std::log(most)));
}

Vector3d CaseMaker::RobotPoint(const Configuration& q) {
  const Kinematics<kArmJoints> k(TracerUf7(), q);
  const auto& spheres = TracerUf7Shapes().spheres;
  const BodySphere& sphere = spheres[rng_.Index(spheres.size())];
  return k.Point(sphere.body, sphere.p_L);
}

Configuration CaseMaker::Place() {
  Configuration q;
  q.head<3>() << rng_.Uniform(0, 1.5), rng_.Uniform(0, 1.5),
      rng_.Uniform(-std::numbers::pi, std::numbers::pi);
  for (int j = 0; j < kArmJoints; ++j) {
    const ArmJoint& joint = TracerUf7().arm.joints[j];
    q(3 + j) = rng_.Uniform(std::max(joint.q_min_rad, -std::numbers::pi),
                            std::min(joint.q_max_rad, std::numbers::pi));
  }
  return q;
}

/// Somewhere near a part of the robot at q, or a little too near.
PlaneEstimate CaseMaker::Plane(const Configuration& q) {
  const Vector3d p_W = RobotPoint(q);
  return Plane(p_W, rng_.Uniform(-0.05, 0.6));
}

PipeEstimate CaseMaker::Pipe(const Configuration& q) {
  const Vector3d p_W = RobotPoint(q);
  return Pipe(p_W, rng_.Uniform(-0.05, 0.6));
}

PlaneEstimate CaseMaker::Plane(const Vector3d& p_W, double distance_m) {
  PlaneEstimate plane;
  plane.n_W = Direction();
  plane.e1_W = plane.n_W.unitOrthogonal();
  plane.e2_W = plane.n_W.cross(plane.e1_W);
  plane.p_WCentroid = p_W - distance_m * plane.n_W;
  plane.d_m = plane.n_W.dot(plane.p_WCentroid);
  for (const int i : {0, 1}) {
    plane.extent_lo_m[i] = -Scale(0.05, 3);
    plane.extent_hi_m[i] = Scale(0.05, 3);
  }
  // n turns about the rectangle's axes through its centroid, and d shifts: rank 3.
  Mat<4, 3> G = Mat<4, 3>::Zero();
  G.col(0) << plane.e1_W, plane.e1_W.dot(plane.p_WCentroid);
  G.col(1) << plane.e2_W, plane.e2_W.dot(plane.p_WCentroid);
  G(3, 2) = Scale(1e-4, kMaxDeviation);
  G.leftCols<2>() *= Scale(1e-4, kMaxDeviation);
  plane.covariance = G * G.transpose();
  return plane;
}

PipeEstimate CaseMaker::Pipe(const Vector3d& p_W, double distance_m) {
  PipeEstimate pipe;
  const Vector3d e_W = Direction();
  pipe.l_W = e_W.unitOrthogonal();
  const Vector3d m_W = pipe.l_W.cross(e_W);
  const double turn = rng_.Uniform(0, std::numbers::pi);
  pipe.l_W = std::cos(turn) * pipe.l_W + std::sin(turn) * m_W;
  pipe.radius_m = rng_.Uniform(0.01, 0.1);
  pipe.p_W = p_W - (pipe.radius_m + distance_m) * e_W;
  pipe.extent_lo_m = -Scale(0.02, 3);
  pipe.extent_hi_m = Scale(0.02, 3);
  // p and l move across the axis only, the radius besides: rank 5.
  const Vector3d e2_W = pipe.l_W.cross(e_W);
  const double place_m = Scale(1e-4, kMaxDeviation);
  const double tilt_rad = Scale(1e-4, kMaxDeviation);
  Mat<7, 5> G = Mat<7, 5>::Zero();
  G.block<3, 1>(0, 0) = place_m * e_W;
  G.block<3, 1>(0, 1) = place_m * e2_W;
  G.block<3, 1>(3, 2) = tilt_rad * e_W;
  G.block<3, 1>(3, 3) = tilt_rad * e2_W;
  G(6, 4) = Scale(1e-4, kMaxDeviation);
  pipe.covariance = G * G.transpose();
  return pipe;
}

CaseBox CaseMaker::Box(const Configuration& q) {
  const Vector3d center = RobotPoint(q) + rng_.Uniform(0, 0.4) * Direction();
  const Vector3d half{Scale(0.02, 0.15), Scale(0.02, 0.15), Scale(0.02, 0.15)};
  return {center - half, center + half};
}

void CaseMaker::Want(const Configuration& q, Goal& goal) {
  const Kinematics<kArmJoints> k(TracerUf7(), q);
  goal.p_WS = k.p_WS() + Scale(0.01, 3) * Direction();
  goal.z_WS = Direction();
  goal.path.clear();
  const int most = rng_.Index(2) == 0 ? 0 : rng_.Index(2) == 0 ? 1 : Goal::kMaxWaypoints;
  const bool same = rng_.Index(2) == 0;  // a way that stands still is gone along in one cycle
  Configuration at = q;
  for (int i = 0; i < most; ++i) {
    if (!same || i == 0) {
      Jitter(at);
    }
    static_cast<void>(goal.path.push_back(at));
  }
}

CaseStep CaseMaker::Step(const Configuration& q) {
  CaseStep step;
  step.q = q;
  step.cycles = rng_.Index(2) == 0 ? 1 : 1 + rng_.Index(kMaxCycles);
  step.alone = step.cycles > 3;  // many among primitives take long to count
  Want(q, step.goal);
  return step;
}

CycleCase CaseMaker::Draw(const CycleCase& like) {
  CycleCase c;
  c.period_s = like.period_s;
  c.alpha = like.alpha;
  c.joint_risk = like.joint_risk;
  const Configuration q = Place();
  const int planes = rng_.Index(2) == 0 ? Scene::kMaxPlanes : rng_.Index(Scene::kMaxPlanes + 1);
  const int pipes = rng_.Index(2) == 0 ? Scene::kMaxPipes : rng_.Index(Scene::kMaxPipes + 1);
  for (int i = 0; i < planes; ++i) {
    static_cast<void>(c.scene.planes.push_back(Plane(q)));
  }
  for (int i = 0; i < pipes; ++i) {
    static_cast<void>(c.scene.pipes.push_back(Pipe(q)));
  }
  const int boxes = rng_.Index(kMaxBoxes + 1);
  for (int i = 0; i < boxes; ++i) {
    c.boxes.push_back(Box(q));
  }
  const int steps = 1 + rng_.Index(3);
  for (int i = 0; i < steps; ++i) {
    Configuration near = q;
    Jitter(near);
    c.steps.push_back(Step(near));
  }
  c.steps.back().cycles = 1;
  c.steps.back().alone = false;
  Number(c);
  return c;
}

CycleCase CaseMaker::Crowd(const CycleCase& like) {
  CycleCase c;
  c.period_s = like.period_s;
  c.alpha = like.alpha;
  c.joint_risk = like.joint_risk;
  Configuration q = Place();
  q.tail<kArmJoints>() = HomeJoints(TracerUf7());
  const Kinematics<kArmJoints> k(TracerUf7(), q);
  Vector3d middle_W = Vector3d::Zero();
  for (const BodySphere& sphere : TracerUf7Shapes().spheres) {
    middle_W += k.Point(sphere.body, sphere.p_L) / TracerUf7Shapes().spheres.size();
  }
  for (int i = 0; i < Scene::kMaxPlanes; ++i) {
    const double distance_m = 0.4 - 0.3 * i / Scene::kMaxPlanes;
    PlaneEstimate plane = Plane(middle_W, distance_m);
    PipeEstimate pipe = Pipe(middle_W, distance_m);
    for (const int axis : {0, 1}) {
      plane.extent_lo_m[axis] = -3;
      plane.extent_hi_m[axis] = 3;
    }
    pipe.extent_lo_m = -3;
    pipe.extent_hi_m = 3;
    static_cast<void>(c.scene.planes.push_back(plane) && c.scene.pipes.push_back(pipe));
  }
  c.boxes.push_back(Box(q));
  for (const bool alone : {true, false}) {  // to have a last command, which looks ahead
    CaseStep step = Step(q);
    step.alone = alone;
    step.cycles = alone ? kMaxCycles : 2;
    c.steps.push_back(step);
  }
  Number(c);
  return c;
}

}  // namespace pipewright::timing
