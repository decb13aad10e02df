// SPDX-License-Identifier: MIT
#include "hil/world/start_check.h"

#include <algorithm>
#include <sstream>

#include "hil/world/clearance.h"

namespace pipewright::hil {
namespace {

void CheckJoints(const std::string& where, std::span<const double> joints_rad,
                 const RobotBodies& robot, std::vector<std::string>& errors) {
  for (std::size_t i = 0; i < joints_rad.size(); ++i) {
    if (joints_rad[i] < robot.joint_min_rad[i] || joints_rad[i] > robot.joint_max_rad[i]) {
      std::ostringstream text;
      text << where << ".joints_rad: joint " << i + 1 << " at " << joints_rad[i]
           << " is beyond its limits, [" << robot.joint_min_rad[i] << ", " << robot.joint_max_rad[i]
           << "]";
      errors.push_back(text.str());
    }
  }
}

}  // namespace

StartCheck CheckStart(const Scenario& scenario, const RobotBodies& robot,
                      std::span<const double> home_rad) {
  StartCheck check;
  const StartPose& start = scenario.start;
  const std::span<const double> joints_rad =
      start.joints_rad.empty() ? home_rad : std::span<const double>(start.joints_rad);
  CheckJoints(start.where, joints_rad, robot, check.errors);
  if (!check.errors.empty()) {
    return check;
  }
  RobotBodies::Pose pose;
  robot.forward(start.x_m, start.y_m, start.yaw_rad, joints_rad, pose);
  ClearanceMeter meter(scenario.solids, robot);
  const Clearance clearance = meter.Measure(pose.X_WL);
  for (const std::string& touched : meter.touched()) {
    check.errors.push_back(start.where + ": the robot touches something there: " + touched);
  }
  const NearestPair& nearest =
      clearance.plane.distance_m < clearance.pipe.distance_m ? clearance.plane : clearance.pipe;
  if (check.errors.empty() && nearest.distance_m < start.clearance_m) {
    std::ostringstream text;
    text << start.where << ".clearance_m: is " << start.clearance_m << ", but "
         << scenario.solids[static_cast<std::size_t>(nearest.other)].name << " is "
         << nearest.distance_m << " m away";
    check.warnings.push_back(text.str());
  }
  return check;
}

}  // namespace pipewright::hil
