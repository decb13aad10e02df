// SPDX-License-Identifier: MIT
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "perception/scene.h"
#include "plan/goal.h"
#include "platform/robot/robot.h"

namespace pipewright::timing {

/// Occupied space, in whole voxels.
struct CaseBox {
  Vector3d lo_W = Vector3d::Zero();
  Vector3d hi_W = Vector3d::Zero();
};

/// The robot at one place with one goal, for some cycles. It stands still there: whatever the law
/// commands changes only the last command, from which the next cycle's limits are taken.
struct CaseStep {
  int cycles = 1;
  bool alone = false;  ///< no primitives near: the last command grows
  Configuration q = Configuration::Zero();
  Goal goal;  ///< its id is the step's place in the case, from 1
};

/// Whatever decides how long the control law takes in a cycle: what is near, where the robot is,
/// what it is to do, and by the steps before what was remembered (the last command, active rows).
struct CycleCase {
  double period_s = 0.01;
  double alpha = 0.7;
  bool joint_risk = false;
  std::vector<CaseBox> boxes;
  Scene scene;
  std::vector<CaseStep> steps;
};

/// Gives every primitive and every goal the id that its place says, from 1.
void Number(CycleCase& c);

/// As text, a line a thing, numbers such that the same case is read back.
void Write(const CycleCase& c, std::ostream& out);

/// False: `error` says which line is not understood.
bool Read(std::istream& in, CycleCase& c, std::string& error);

}  // namespace pipewright::timing
