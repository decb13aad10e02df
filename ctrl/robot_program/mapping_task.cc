// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/mapping_task.h"

#include <optional>

#include "platform/robot/kinematics.h"
#include "platform/robot/shapes.h"

namespace pipewright {
namespace {

using Body = Kinematics<kArmJoints>;
using Boxes = FixedVector<SelfBox, SelfBox::kMax>;

constexpr double kFillStep_m = 0.05;

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
      noise_(config.noise),
      tracker_(config.primitives, config.seed),
      localizer_(config.localization) {}

void MappingTask::Start(const Configuration& q) {
  // Balls of that radius about points that fill each part: nowhere farther out than promised.
  for (const SelfBox& part : BoxesAt(Body(robot_, q))) {
    const Eigen::Array3i steps = (2 * part.half_m / kFillStep_m).array().ceil().cast<int>().max(1);
    for (int i = 0; i <= steps.x(); ++i) {
      for (int j = 0; j <= steps.y(); ++j) {
        for (int k = 0; k <= steps.z(); ++k) {
          const Eigen::Array3d share = Eigen::Array3d(i, j, k) / steps.cast<double>();
          const Vector3d p_G = ((2 * share - 1) * part.half_m.array()).matrix();
          map_.MarkSweptSphere(part.X_WG * p_G, config_.start_clearance_m);
        }
      }
    }
  }
  field_.Update(map_);
}

/// Moves q's base to where guess and cloud together find it. @returns whether that is certain
/// enough for a map
bool MappingTask::Localize(const Isometry3d& X_BS, const Motion& motion, Configuration& q) {
  PoseFix fix;
  const BasePose guess{.stamp = cloud_.stamp,
                       .x_m = q(0),
                       .y_m = q(1),
                       .phi_rad = q(2),
                       .covariance = motion.base_covariance};
  const Status status =
      localizer_.Step(cloud_, X_BS, guess, motion.base_doubted, motion.base_worst, fix);
  if (status == Status::kFault) {
    fix_ = PoseFix{.stamp = cloud_.stamp, .fits = false};
  } else if (status == Status::kOk) {
    fix_ = fix;
  }
  q.head<3>() = localizer_.pose();
  return localizer_.added();
}

Status MappingTask::Step(const DepthFrame& frame, const Motion& motion) {
  ++counters_.frames;
  fix_.reset();
  std::optional<Configuration> q = motion.states.At(frame.stamp, config_.max_extrapolation);
  if (!q) {
    ++counters_.without_pose;
    return Status::kStale;
  }
  const Body guess(robot_, *q);
  const Boxes boxes = BoxesAt(guess);
  const Status made = MakeCloud(frame, guess.X_WS(), {boxes.begin(), boxes.end()}, config_.cloud,
                                cloud_, counters_.cloud);
  if (made != Status::kOk) {
    ++counters_.refused;
    return made;
  }
  noise_.Add(cloud_);
  localizer_.Assume(noise_.k_1pm());
  tracker_.Assume(noise_.k_1pm());

  if (config_.localize && !Localize(BaseAt(q->head<3>()).inverse() * guess.X_WS(), motion, *q)) {
    ++counters_.doubted;
    return Status::kOk;
  }
  const Body body(robot_, *q);
  cloud_.X_WS = body.X_WS();

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
  if (config_.localize) {
    localizer_.Take(tracker_.scene());
  }
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
