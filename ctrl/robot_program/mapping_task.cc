// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/mapping_task.h"

#include <optional>

#include "platform/robot/kinematics.h"
#include "platform/robot/shapes.h"

namespace pipewright {
namespace {

using Body = Kinematics<kArmJoints>;
using Boxes = FixedVector<SelfBox, SelfBox::kMax>;

/// The robot as built, for the camera: what it must not take for the world.
Boxes BoxesAt(const Body& body) {
  Boxes boxes;
  for (const BodyShape& shape : TracerUf7Shapes().shapes) {
    static_cast<void>(boxes.push_back({body.X_WL(shape.body) * shape.X_LG, shape.half_m}));
  }
  return boxes;
}

}  // namespace

MappingTask::MappingTask(const MappingConfig& config, const RobotModel<kArmJoints>& robot)
    : config_(config),
      robot_(robot),
      map_(config.map),
      field_(config.map),
      tracker_(config.primitives, config.seed) {}

void MappingTask::Start(const Configuration& q) {
  const RobotShapes& shapes = TracerUf7Shapes();
  const Body body(robot_, q);
  for (const BodySphere& sphere : shapes.spheres) {
    map_.MarkSweptSphere(body.Point(sphere.body, sphere.p_L),
                         sphere.r_m + config_.start_clearance_m);
  }
  for (const BaseDisc& disc : shapes.discs) {
    for (const double z_m : {shapes.discs_z_lo_m, shapes.discs_z_hi_m}) {
      map_.MarkSweptSphere(body.Point(Body::kBase, {disc.p_B.x(), disc.p_B.y(), z_m}),
                           disc.r_m + config_.start_clearance_m);
    }
  }
  field_.Update(map_);
}

Status MappingTask::Step(const DepthFrame& frame, const StateHistory& history) {
  ++counters_.frames;
  const std::optional<Configuration> q = history.At(frame.stamp, config_.max_extrapolation);
  if (!q) {
    ++counters_.without_pose;
    return Status::kStale;
  }
  const Body body(robot_, *q);
  const Boxes boxes = BoxesAt(body);
  const Status made = MakeCloud(frame, body.X_WS(), {boxes.begin(), boxes.end()}, config_.cloud,
                                cloud_, counters_.cloud);
  if (made != Status::kOk) {
    ++counters_.refused;
    return made;
  }

  const Eigen::Isometry3f X_WS = cloud_.X_WS.cast<float>();
  int count = 0;
  for (int i = 0; i < cloud_.size(); ++i) {
    if (cloud_.valid[i] != 0) {
      points_W_[count++] = X_WS * cloud_.p_SQ[i];
    }
  }
  map_.InsertScan(points_W_.data(), count, X_WS.translation(), config_.max_range_m);
  map_.MarkCovered(body.p_WP(), config_.probe_radius_m);
  tracker_.Step(cloud_);
  field_.Update(map_);
  return Status::kOk;
}

int MappingTask::Cover(const Configuration& q) {
  return map_.MarkCovered(Body(robot_, q).p_WP(), config_.probe_radius_m);
}

void MappingTask::DeclareResidual(const ResidualVoxels& residual) {
  for (const VoxelIndex& v : residual.voxels) {
    map_.SetResidual(v, true);
  }
}

}  // namespace pipewright
