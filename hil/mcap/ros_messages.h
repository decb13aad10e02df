// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hil/mcap/cdr_writer.h"

/// The ROS 2 messages that an inspection of the robot needs, as ROS's common_interfaces defines
/// them. Units are ROS's, and ours: m, rad, s.
namespace pipewright::hil {

/// The name of a message's type, its fields, and those of each type that it is made of.
struct RosType {
  std::string_view name;
  std::array<std::string_view, 10> parts;  ///< what is not used is empty

  /// All in one text as rosbag2 stores it, encoding "ros2msg".
  std::string Definition() const;
};
extern const RosType kRosJointState;
extern const RosType kRosOdometry;
extern const RosType kRosTransforms;
extern const RosType kRosTwistStamped;
extern const RosType kRosDiagnostics;
extern const RosType kRosPointCloud;

struct RosHeader {
  std::int64_t stamp_ns = 0;  ///< seconds beyond int32 are its greatest: ROS's time has no more
  std::string_view frame;
};

/// Empty: not known, as ROS has it.
struct RosJointState {
  RosHeader header;
  std::span<const std::string> names;
  std::span<const double> position_rad;
  std::span<const double> velocity_radps;
};

/// A body's pose on the floor in `header.frame`, and its twist in its own.
struct RosOdometry {
  RosHeader header;
  std::string_view child_frame;
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
  std::array<double, 9> covariance{};  ///< of (x, y, yaw), row-major
  double v_mps = 0;
  double omega_radps = 0;
};

/// The pose of `child_frame` in `header.frame`.
struct RosTransform {
  RosHeader header;
  std::string_view child_frame;
  std::array<double, 3> position_m{};
  std::array<double, 4> orientation{};  ///< unit quaternion: x, y, z, w
};

struct RosTwist {
  RosHeader header;
  double v_mps = 0;
  double omega_radps = 0;
};

enum class RosLevel : std::uint8_t { kOk = 0, kWarn = 1, kError = 2, kStale = 3 };

struct RosDiagnostic {
  RosHeader header;
  RosLevel level = RosLevel::kOk;
  std::string_view name;
  std::string_view message;
  std::string_view hardware;
  std::span<const std::pair<std::string, std::string>> values;
};

/// Points by rows, as an image has them; NaN where there is none.
struct RosPointCloud {
  RosHeader header;
  int width = 0;
  int height = 0;
  std::span<const float> xyz_m;  ///< 3 for each of width * height points
};

/// Each writes one message, from its beginning.
void WriteRos(CdrWriter& to, const RosJointState& message);
void WriteRos(CdrWriter& to, const RosOdometry& message);
void WriteRos(CdrWriter& to, const RosTwist& message);
void WriteRos(CdrWriter& to, const RosPointCloud& message);
/// An array of one.
void WriteRos(CdrWriter& to, const RosDiagnostic& message);
void WriteRos(CdrWriter& to, const RosTransform& message);
/// The pose alone, as a transform.
void WriteRosTransform(CdrWriter& to, const RosOdometry& message);

}  // namespace pipewright::hil
