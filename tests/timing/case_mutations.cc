// SPDX-License-Identifier: MIT
#include <algorithm>
#include <utility>

#include "platform/robot/uf7.h"
#include "tests/timing/case_maker.h"

namespace pipewright::timing {
namespace {

constexpr std::size_t kMaxSteps = 5;

template <typename T, int n>
void Drop(FixedVector<T, n>& from, int which) {
  const FixedVector<T, n> all = from;
  from.clear();
  for (int i = 0; i < all.size(); ++i) {
    static_cast<void>(i == which || from.push_back(all[i]));
  }
}

}  // namespace

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
