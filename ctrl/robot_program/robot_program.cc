// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/robot_program.h"

namespace pipewright {
namespace {

Configuration StartOf(const RobotProgramConfig& config) {
  Configuration q;
  const BasePose& pose = config.control.start;
  q << pose.x_m, pose.y_m, pose.phi_rad, config.start_joints_rad;
  return q;
}

}  // namespace

RobotProgram::RobotProgram(const RobotProgramConfig& config, const RobotModel<kArmJoints>& robot)
    : control_(config.control, robot),
      mapping_(config.mapping, robot),
      planning_(config.mission, config.mapping.map),
      surrounding_(Surrounding(config.mapping.map)),
      snapshot_(MapSnapshot(config.mapping.map)),
      camera_timeout_(config.camera_timeout) {
  mapping_.Start(StartOf(config));
  surrounding_.Back().field = mapping_.field();
  surrounding_.Publish();
}

const ControlReport& RobotProgram::StepControl(Time now) {
  if (stop_requested_.load(std::memory_order_relaxed) && !stopping_) {
    stopping_ = true;
    control_.Stop();
  }
  base_out_.clear();
  arm_out_.clear();
  if (fix_.HasNew()) {
    control_.Correct(fix_.Read());
  }
  const Surrounding& around = surrounding_.Read();
  const ControlReport& report =
      control_.Step(now, around.scene, around.field, goal_.Read(), base_out_, arm_out_);
  states_.Add(report.state);
  Motion& motion = motion_.Back();
  motion.states = states_;
  motion.base_covariance = report.pose.covariance;
  motion.base_worst = report.pose.worst_covariance;
  motion.base_doubted = report.pose.doubted;
  motion_.Publish();
  report_.Write(report);
  return report;
}

void RobotProgram::TakeResidual() {
  if (residual_.HasNew()) {
    mapping_.DeclareResidual(residual_.Read());
  }
}

Status RobotProgram::Map(const DepthFrame& frame) {
  TakeResidual();
  const Status status = mapping_.Step(frame, motion_.Read());
  if (status != Status::kOk) {
    return status;
  }
  if (mapping_.fix()) {
    fix_.Write(*mapping_.fix());
  }
  Surrounding& around = surrounding_.Back();
  around.scene = mapping_.scene();
  around.field = mapping_.field();
  surrounding_.Publish();

  MapSnapshot& snapshot = snapshot_.Back();
  snapshot.stamp = frame.stamp;
  snapshot.map = mapping_.map();
  snapshot.field = mapping_.field();
  snapshot.scene = mapping_.scene();
  snapshot_.Publish();
  return Status::kOk;
}

const MissionOutput& RobotProgram::Plan(Time now) {
  const ControlReport& report = report_.Read();
  const MapSnapshot& snapshot = snapshot_.Read();
  if (!report.state.valid || snapshot.stamp != map_stamp_) {
    camera_seen_ = now;
    map_stamp_ = snapshot.stamp;
  }
  camera_lost_ = camera_lost_ || now - camera_seen_ > camera_timeout_;
  const bool fault = camera_lost_ || report.phase == ControlPhase::kFault;
  const MissionOutput& output = planning_.Step(now, snapshot, report, fault);
  if (planning_.goal().id != goal_id_) {
    goal_id_ = planning_.goal().id;
    goal_.Write(planning_.goal());
  }
  if (!planning_.NewResidual().empty()) {
    ResidualVoxels& residual = residual_.Back();
    residual.voxels.clear();
    for (const VoxelIndex& v : planning_.NewResidual()) {
      if (!residual.voxels.push_back(v)) {
        break;  // the rest stays unknown, which is the safe side
      }
    }
    residual_.Publish();
  }
  if (output.state == MissionState::kDone || output.state == MissionState::kFault) {
    RequestStop();
  }
  return output;
}

}  // namespace pipewright
