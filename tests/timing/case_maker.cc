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

constexpr int kMaxSteps = 5;
constexpr int kMaxBoxes = 4;
constexpr int kMaxCycles = 30;         ///< of a step: the last command is then at its limits
constexpr double kMaxDeviation = 0.1;  ///< of a primitive's parameters, in m and 1

void Number(CycleCase& c) {
  std::uint32_t id = 0;
  for (PlaneEstimate& plane : c.scene.planes) {
    plane.id = ++id;
  }
  id = 0;
  for (PipeEstimate& pipe : c.scene.pipes) {
    pipe.id = ++id;
  }
  id = 0;
  for (CaseStep& step : c.steps) {
    step.goal.id = ++id;
  }
}

template <typename T, int n>
void Drop(FixedVector<T, n>& from, int which) {
  const FixedVector<T, n> all = from;
  from.clear();
  for (int i = 0; i < all.size(); ++i) {
    static_cast<void>(i == which || from.push_back(all[i]));
  }
}

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

void CaseMaker::Jitter(Configuration& q) {
  const double size = Scale(1e-4, 1);
  for (int i = 0; i < kDof; ++i) {
    q(i) += rng_.Index(2) == 0 ? size * rng_.Normal() : 0;
  }
  for (int j = 0; j < kArmJoints; ++j) {
    const ArmJoint& joint = TracerUf7().arm.joints[j];
    q(3 + j) = std::clamp(q(3 + j), joint.q_min_rad, joint.q_max_rad);
  }
}

void CaseMaker::Jitter(PlaneEstimate& plane) {
  if (rng_.Index(3) == 0) {
    plane.covariance *= Scale(0.1, 10);
    return;
  }
  const double shift_m = Scale(1e-4, 0.2) * rng_.Normal();
  plane.p_WCentroid += shift_m * plane.n_W;
  plane.d_m += shift_m;
}

void CaseMaker::Jitter(PipeEstimate& pipe) {
  if (rng_.Index(3) == 0) {
    pipe.covariance *= Scale(0.1, 10);
    return;
  }
  pipe.p_W += Scale(1e-4, 0.2) * rng_.Normal() * pipe.l_W.cross(Direction());
}

void CaseMaker::MutateScene(CycleCase& c) {
  const Configuration& q = c.steps.back().q;
  auto& planes = c.scene.planes;
  auto& pipes = c.scene.pipes;
  const bool plane = rng_.Index(2) == 0;
  const int count = plane ? planes.size() : pipes.size();
  const int which = count == 0 ? 0 : rng_.Index(count);
  const int how = count == 0 ? 0 : rng_.Index(6);
  if (how == 0) {
    static_cast<void>(plane ? planes.push_back(Plane(q)) : pipes.push_back(Pipe(q)));
  } else if (how == 1) {
    plane ? Drop(planes, which) : Drop(pipes, which);
  } else if (how == 2) {
    plane ? void(planes[which] = Plane(q)) : void(pipes[which] = Pipe(q));
  } else if (how == 3) {
    const int other = rng_.Index(count);
    plane ? std::swap(planes[which], planes[other]) : std::swap(pipes[which], pipes[other]);
  } else {
    plane ? Jitter(planes[which]) : Jitter(pipes[which]);
  }
}

void CaseMaker::MutateSteps(CycleCase& c) {
  const int which = rng_.Index(static_cast<int>(c.steps.size()));
  CaseStep& step = c.steps[static_cast<std::size_t>(which)];
  switch (rng_.Index(7)) {
    case 0:
      Want(step.q, step.goal);
      break;
    case 1:
      step.goal.p_WS += Scale(1e-3, 1) * Direction();
      step.goal.z_WS = (step.goal.z_WS + Scale(1e-3, 1) * Direction()).normalized();
      break;
    case 2:
      step.cycles = step.alone ? 1 + rng_.Index(kMaxCycles) : 1 + rng_.Index(3);
      break;
    case 3:
      if (c.steps.size() < kMaxSteps) {
        CaseStep more = Step(c.steps.back().q);
        c.steps.insert(c.steps.begin() + which, more);
      } else {
        c.steps.erase(c.steps.begin() + which);
      }
      break;
    case 4:
      if (c.steps.size() > 1) {
        c.steps.erase(c.steps.begin() + which);
      }
      break;
    default:
      Jitter(step.q);
      break;
  }
  c.steps.back().alone = false;
  c.steps.back().cycles = std::min(c.steps.back().cycles, 3);
}

void CaseMaker::MutateBoxes(CycleCase& c) {
  const auto count = static_cast<int>(c.boxes.size());
  if (count == 0 || (count < kMaxBoxes && rng_.Index(2) == 0)) {
    c.boxes.push_back(Box(c.steps.back().q));
  } else if (rng_.Index(2) == 0) {
    c.boxes.erase(c.boxes.begin() + rng_.Index(count));
  } else {
    c.boxes[static_cast<std::size_t>(rng_.Index(count))] = Box(c.steps.back().q);
  }
}

CycleCase CaseMaker::Mutate(const CycleCase& c) {
  CycleCase other = c;
  const int changes = 1 + rng_.Index(3);
  for (int i = 0; i < changes; ++i) {
    const int what = rng_.Index(16);
    if (what == 0) {
      MutateBoxes(other);  // seldom: the field is then made anew
    } else if (what < 8) {
      MutateScene(other);
    } else {
      MutateSteps(other);
    }
  }
  Number(other);
  return other;
}

}  // namespace pipewright::timing
