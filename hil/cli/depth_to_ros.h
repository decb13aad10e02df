// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "hil/canlog/log_frame.h"
#include "hil/cli/ros_topics.h"
#include "hil/replay/depth_reader.h"
#include "platform/can/cia402.h"

namespace pipewright::hil {

/// The depth frames that belong to a CAN log as ROS 2 messages, each with its exposure's stamp:
///
///   /camera/points  sensor_msgs/PointCloud2 in `camera`, which is S: as ROS has an optical frame.
///                   x, y, z as float32 of every `every`-th pixel each way, those that the robot's
///                   own clouds have, row by row. NaN where the camera has no reading, or one out
///                   of its range
///   /tf             base_link to camera, by the robot's kinematics and the joints (TPDO1) of the
///                   first channel that has any, each moved on from its last reading at that
///                   reading's velocity, for as long at most as the robot does. Without a reading
///                   of each joint: none
///
/// Both clocks are one: a run's own log and depth frames count from its start. Frames of before the
/// log's first or behind its last are left out. Memory: one depth frame and its points.
class DepthToRos {
 public:
  DepthToRos(RosTopics& to, DepthReader& from, int every);

  /// The next frame of the log in the order of time. Writes the depth frames of before it.
  void Take(const LogFrame& frame);
  /// The log has ended: writes those of up to its last frame, and reads the rest.
  void End();

  /// Depth frames, whose times are first_ns to last_ns, and those of the log.
  struct Figures {
    std::uint64_t written = 0;
    std::uint64_t outside = 0;         ///< the log's time: left out
    std::uint64_t without_joints = 0;  ///< of those written: no transform
    std::int64_t first_ns = 0;
    std::int64_t last_ns = 0;
    std::optional<std::int64_t> log_first_ns;  ///< nothing: there is no frame with a time
    std::int64_t log_last_ns = 0;
  };
  const Figures& figures() const { return figures_; }

 private:
  struct Joint {
    std::optional<std::int64_t> at_ns;
    can::JointFeedback read;
  };

  void Advance();
  void WriteBefore(std::int64_t time_ns);
  void WritePoints();
  void WriteTransform();
  void TakeJoint(const LogFrame& frame);

  RosTopics& to_;
  DepthReader& from_;
  const int every_;
  CdrWriter cdr_;
  std::unique_ptr<DepthFrame> next_;
  bool has_next_ = false;
  std::vector<float> xyz_m_;
  std::optional<std::uint8_t> arm_channel_;
  std::array<Joint, can::kArmNodes> joints_;
  Figures figures_;
};

}  // namespace pipewright::hil
