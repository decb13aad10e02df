// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/site_config.h"

#include "perception/map/voxel_grid.h"
#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

VoxelIndex Index(const std::array<int, 3>& v) { return {v[0], v[1], v[2]}; }

MapConfig MapOf(const Site& site) {
  MapConfig map;
  const VoxelRange stored = VoxelsOf(site.map);
  const VoxelRange workspace = VoxelsOf(site.workspace);
  map.lo = Index(stored.lo);
  map.hi = Index(stored.hi);
  map.workspace_lo = Index(workspace.lo);
  map.workspace_hi = Index(workspace.hi);
  map.width_m = kVoxelWidth_m;
  map.brick_capacity = BricksOfBox(map);
  return map;
}

}  // namespace

void SetSite(const Site& site, const RobotModel<kArmJoints>& robot, RobotProgramConfig* config) {
  const StartPose& start = site.start;
  config->start_joints_rad = start.joints_rad.empty()
                                 ? HomeJoints(robot)
                                 : ArmVector(Eigen::Map<const ArmVector>(start.joints_rad.data()));
  config->control.start.x_m = start.x_m;
  config->control.start.y_m = start.y_m;
  config->control.start.phi_rad = start.yaw_rad;
  config->control.localization.odometry.track_m = robot.base.track_m;
  config->mapping.map = MapOf(site);
  config->mapping.start_clearance_m = start.clearance_m;
}

}  // namespace pipewright
