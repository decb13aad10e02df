// SPDX-License-Identifier: MIT
#include "hil/cli/depth_to_ros.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "ctrl/robot_program/mapping_task.h"
#include "platform/robot/kinematics.h"
#include "platform/robot/uf7.h"

namespace pipewright::hil {
namespace {

static_assert(can::kArmNodes == kArmJoints);

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

}  // namespace

DepthToRos::DepthToRos(RosTopics& to, DepthReader& from, int every)
    : to_(to), from_(from), every_(every), next_(std::make_unique<DepthFrame>()) {
  Advance();
  figures_.first_ns = figures_.last_ns;
}

void DepthToRos::Advance() {
  Time given;
  has_next_ = from_.Next(*next_, given);
  if (has_next_) {
    figures_.last_ns = next_->stamp.time_since_epoch().count();
  }
}

void DepthToRos::Take(const LogFrame& frame) {
  figures_.log_first_ns = figures_.log_first_ns.value_or(frame.stamp_ns);
  figures_.log_last_ns = std::max(figures_.log_last_ns, frame.stamp_ns);
  WriteBefore(frame.stamp_ns);
  TakeJoint(frame);
}

void DepthToRos::End() {
  if (figures_.log_first_ns) {
    WriteBefore(figures_.log_last_ns + 1);
  }
  for (; has_next_; Advance()) {
    ++figures_.outside;
  }
}

void DepthToRos::WriteBefore(std::int64_t time_ns) {
  for (; has_next_ && next_->stamp.time_since_epoch().count() < time_ns; Advance()) {
    if (next_->stamp.time_since_epoch().count() < *figures_.log_first_ns) {
      ++figures_.outside;
      continue;
    }
    WriteTransform();  // first: who shows the points then knows where they are
    WritePoints();
    ++figures_.written;
  }
}

void DepthToRos::WritePoints() {
  const CameraIntrinsics& c = next_->camera;
  const int width = c.width / every_;
  const int height = c.height / every_;
  xyz_m_.clear();
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const int u = column * every_ + every_ / 2;
      const int v = row * every_ + every_ / 2;
      const double z_m = 1e-3 * next_->depth_mm[static_cast<std::size_t>(v * c.width + u)];
      const bool good = z_m > 0 && c.z_min_m <= z_m && z_m <= c.z_max_m;
      for (const double value : {(u - c.cx) / c.fx * z_m, (v - c.cy) / c.fy * z_m, z_m}) {
        xyz_m_.push_back(good ? static_cast<float>(value) : kNone);
      }
    }
  }
  const std::int64_t stamp_ns = next_->stamp.time_since_epoch().count();
  WriteRos(cdr_, RosPointCloud{{stamp_ns, "camera"}, width, height, xyz_m_});
  to_.Write(to_.Channel("/camera/points", kRosPointCloud), stamp_ns, cdr_);
}

void DepthToRos::WriteTransform() {
  const std::int64_t stamp_ns = next_->stamp.time_since_epoch().count();
  const Duration most = MappingConfig().max_extrapolation;
  Configuration q = Configuration::Zero();  // the base at W's origin: W is B
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const Joint& joint = joints_[i];
    if (!joint.at_ns || std::abs(stamp_ns - *joint.at_ns) > most.count()) {
      ++figures_.without_joints;
      return;
    }
    q(3 + static_cast<int>(i)) =
        joint.read.position_rad +
        ToSeconds(Duration(stamp_ns - *joint.at_ns)) * joint.read.velocity_radps;
  }
  const Isometry3d X_BS = Kinematics<kArmJoints>(TracerUf7(), q).X_WS();
  const Vector3d& p_BS = X_BS.translation();
  const Eigen::Quaterniond R_BS(X_BS.linear());
  WriteRos(cdr_, RosTransform{.header = {stamp_ns, "base_link"},
                              .child_frame = "camera",
                              .position_m = {p_BS.x(), p_BS.y(), p_BS.z()},
                              .orientation = {R_BS.x(), R_BS.y(), R_BS.z(), R_BS.w()}});
  to_.Write(to_.Channel("/tf", kRosTransforms), stamp_ns, cdr_);
}

void DepthToRos::TakeJoint(const LogFrame& frame) {
  if (frame.fd || (arm_channel_ && *arm_channel_ != frame.channel)) {
    return;
  }
  const Result<can::JointFeedback> read = can::Decode(can::kJointFeedback, ClassicFrame(frame));
  if (!read.ok()) {
    return;
  }
  arm_channel_ = frame.channel;
  const int node = can::NodeOf(can::kJointFeedback.head, frame.id);
  Joint& joint = joints_[static_cast<std::size_t>(node - 1)];
  if (frame.stamp_ns >= joint.at_ns.value_or(frame.stamp_ns)) {
    joint = {frame.stamp_ns, *read};
  }
}

}  // namespace pipewright::hil
