// SPDX-License-Identifier: MIT
#include "hil/mcap/ros_messages.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pipewright::hil {
namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

void PutHeader(CdrWriter& to, const RosHeader& header) {
  const std::int64_t seconds = header.stamp_ns / kNsPerSecond;
  constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
  to.Put(static_cast<std::int32_t>(std::min(seconds, kMost)));
  to.Put(static_cast<std::uint32_t>(header.stamp_ns % kNsPerSecond));
  to.Put(header.frame);
}

void PutNumbers(CdrWriter& to, std::span<const double> values) {
  to.PutLength(values.size());
  for (const double value : values) {
    to.Put(value);
  }
}

/// On the floor, turned about z.
RosTransform FloorPose(const RosOdometry& from) {
  return {.header = from.header,
          .child_frame = from.child_frame,
          .position_m = {from.x_m, from.y_m, 0},
          .orientation = {0, 0, std::sin(from.yaw_rad / 2), std::cos(from.yaw_rad / 2)}};
}

void PutPose(CdrWriter& to, const RosTransform& pose) {
  for (const double value : pose.position_m) {
    to.Put(value);
  }
  for (const double value : pose.orientation) {
    to.Put(value);
  }
}

void PutTwist(CdrWriter& to, double v_mps, double omega_radps) {
  for (const double value : {v_mps, 0.0, 0.0, 0.0, 0.0, omega_radps}) {
    to.Put(value);
  }
}

// clang-format off
constexpr std::string_view kHeader = R"(MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
)";
constexpr std::string_view kTime = R"(MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
)";
constexpr std::string_view kTwist = R"(MSG: geometry_msgs/Twist
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
)";
constexpr std::string_view kVector3 = R"(MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
)";
constexpr std::string_view kQuaternion = R"(MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
)";

}  // namespace

const RosType kRosJointState{"sensor_msgs/msg/JointState", {
R"(std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
)", kHeader, kTime}};

const RosType kRosOdometry{"nav_msgs/msg/Odometry", {
R"(std_msgs/Header header
string child_frame_id
geometry_msgs/PoseWithCovariance pose
geometry_msgs/TwistWithCovariance twist
)", kHeader, kTime,
R"(MSG: geometry_msgs/PoseWithCovariance
geometry_msgs/Pose pose
float64[36] covariance
)",
R"(MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
)",
R"(MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
)", kQuaternion,
R"(MSG: geometry_msgs/TwistWithCovariance
geometry_msgs/Twist twist
float64[36] covariance
)", kTwist, kVector3}};

const RosType kRosTransforms{"tf2_msgs/msg/TFMessage", {
R"(geometry_msgs/TransformStamped[] transforms
)",
R"(MSG: geometry_msgs/TransformStamped
std_msgs/Header header
string child_frame_id
geometry_msgs/Transform transform
)", kHeader, kTime,
R"(MSG: geometry_msgs/Transform
geometry_msgs/Vector3 translation
geometry_msgs/Quaternion rotation
)", kVector3, kQuaternion}};

const RosType kRosTwistStamped{"geometry_msgs/msg/TwistStamped", {
R"(std_msgs/Header header
geometry_msgs/Twist twist
)", kHeader, kTime, kTwist, kVector3}};

const RosType kRosDiagnostics{"diagnostic_msgs/msg/DiagnosticArray", {
R"(std_msgs/Header header
diagnostic_msgs/DiagnosticStatus[] status
)", kHeader, kTime,
R"(MSG: diagnostic_msgs/DiagnosticStatus
byte OK=0
byte WARN=1
byte ERROR=2
byte STALE=3
byte level
string name
string message
string hardware_id
diagnostic_msgs/KeyValue[] values
)",
R"(MSG: diagnostic_msgs/KeyValue
string key
string value
)"}};

const RosType kRosPointCloud{"sensor_msgs/msg/PointCloud2", {
R"(std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
)", kHeader, kTime,
R"(MSG: sensor_msgs/PointField
uint8 INT8=1
uint8 UINT8=2
uint8 INT16=3
uint8 UINT16=4
uint8 INT32=5
uint8 UINT32=6
uint8 FLOAT32=7
uint8 FLOAT64=8
string name
uint32 offset
uint8 datatype
uint32 count
)"}};
// clang-format on

std::string RosType::Definition() const {
  std::string text;
  for (const std::string_view part : parts) {
    if (!text.empty() && !part.empty()) {
      text.append(80, '=').append("\n");
    }
    text += part;
  }
  return text;
}

void WriteRos(CdrWriter& to, const RosJointState& message) {
  to.Begin();
  PutHeader(to, message.header);
  to.PutLength(message.names.size());
  for (const std::string& name : message.names) {
    to.Put(std::string_view(name));
  }
  PutNumbers(to, message.position_rad);
  PutNumbers(to, message.velocity_radps);
  PutNumbers(to, {});  // effort
}

void WriteRos(CdrWriter& to, const RosOdometry& message) {
  to.Begin();
  PutHeader(to, message.header);
  to.Put(message.child_frame);
  PutPose(to, FloorPose(message));
  constexpr std::size_t kNone = 3;
  constexpr std::size_t kOfPlane[6] = {0, 1, kNone, kNone, kNone, 2};  // x y z, turns about x y z
  for (const std::size_t row : kOfPlane) {
    for (const std::size_t column : kOfPlane) {
      const bool told = row != kNone && column != kNone;
      to.Put(told ? message.covariance[3 * row + column] : 0.0);
    }
  }
  PutTwist(to, message.v_mps, message.omega_radps);
  for (int i = 0; i < 36; ++i) {
    to.Put(0.0);  // not known
  }
}

void WriteRos(CdrWriter& to, const RosTwist& message) {
  to.Begin();
  PutHeader(to, message.header);
  PutTwist(to, message.v_mps, message.omega_radps);
}

void WriteRos(CdrWriter& to, const RosDiagnostic& message) {
  to.Begin();
  PutHeader(to, message.header);
  to.PutLength(1);
  to.Put(static_cast<std::uint8_t>(message.level));
  to.Put(message.name);
  to.Put(message.message);
  to.Put(message.hardware);
  to.PutLength(message.values.size());
  for (const auto& [key, value] : message.values) {
    to.Put(std::string_view(key));
    to.Put(std::string_view(value));
  }
}

void WriteRos(CdrWriter& to, const RosTransform& message) {
  to.Begin();
  to.PutLength(1);
  PutHeader(to, message.header);
  to.Put(message.child_frame);
  PutPose(to, message);
}

void WriteRosTransform(CdrWriter& to, const RosOdometry& message) {
  WriteRos(to, FloorPose(message));
}

void WriteRos(CdrWriter& to, const RosPointCloud& message) {
  constexpr std::uint8_t kFloat32 = 7;
  constexpr std::uint32_t kNumberBytes = sizeof(float);
  constexpr std::uint32_t kPointBytes = 3 * kNumberBytes;
  const auto width = static_cast<std::uint32_t>(message.width);
  to.Begin();
  PutHeader(to, message.header);
  to.Put(static_cast<std::uint32_t>(message.height));
  to.Put(width);
  to.PutLength(3);
  std::uint32_t offset = 0;
  for (const std::string_view name : {"x", "y", "z"}) {
    to.Put(name);
    to.Put(offset);
    to.Put(kFloat32);
    to.Put(std::uint32_t{1});  // a number of each
    offset += kNumberBytes;
  }
  to.Put(std::uint8_t{0});  // little-endian, as they lie
  to.Put(kPointBytes);
  to.Put(kPointBytes * width);
  to.PutBytes({reinterpret_cast<const char*>(message.xyz_m.data()), message.xyz_m.size_bytes()});
  to.Put(std::uint8_t{0});  // not dense: points may be NaN
}

}  // namespace pipewright::hil
