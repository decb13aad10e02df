// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hil/canlog/channel_names.h"
#include "hil/canlog/code_names.h"
#include "hil/canlog/id_table.h"
#include "hil/canlog/log_frame.h"
#include "hil/cli/ros_topics.h"
#include "perception/localization/wheel_odometry.h"
#include "platform/can/cia402.h"
#include "platform/can/tracer.h"

namespace pipewright::hil {

/// The frames of base and arm as ROS 2 messages, each with the time of the frame that completes it.
///
///   /joint_states    sensor_msgs/JointState: position and velocity of the joints that have sent
///                    theirs (TPDO1) since the message before. A message ends when all seven have,
///                    or when one comes again: a silent joint is then not in it
///   /joint_commands  the same of the velocities that the joints are told (RPDO1); no positions
///   /odom            nav_msgs/Odometry in `odom`: at each odometer frame (0x311) the pose that the
///                    robot's own wheel odometry has from it and from the twist before it (0x221),
///                    beginning at zero, not corrected by scans; twist as the base tells it. Its
///                    covariance is of x, y and yaw; zero of all that is not known
///   /tf              that pose, odom to base_link
///   /cmd_vel         geometry_msgs/TwistStamped: what the base is told (0x111)
///   /diagnostics     diagnostic_msgs/DiagnosticArray: states, errors, battery, EMCY and error
///                    messages of the controller; of each id when a code in it changes, and once a
///                    second
///
/// The second channel on which a topic's frames come has a topic of its own, /can1/odom; but
/// /diagnostics is one, and tells the channel beside the device.
/// Memory: that of the channels and ids.
class CanToRos {
 public:
  CanToRos(RosTopics& to, const ChannelNames& channels, const ControlModes& modes);
  ~CanToRos();
  CanToRos(const CanToRos&) = delete;
  CanToRos& operator=(const CanToRos&) = delete;

  /// The next frame in the order of time. @pre it is stamped
  void Take(const LogFrame& frame);
  /// Writes the messages that are not complete.
  void End();

 private:
  enum Topic { kJointStates, kJointCommands, kOdom, kTf, kCmdVel, kDiagnostics, kTopics };

  /// What the joints have sent since the message before.
  struct Joints {
    Topic topic = kJointStates;
    bool with_position = true;
    std::int64_t last_ns = 0;
    std::array<bool, can::kArmNodes> have{};
    std::array<double, can::kArmNodes> position_rad{};
    std::array<double, can::kArmNodes> velocity_radps{};
  };
  /// One channel of the log.
  struct Bus {
    std::uint8_t channel = 0;
    Joints states;
    Joints commands{.topic = kJointCommands, .with_position = false};
    WheelOdometry odometry;
    std::optional<can::BaseTwist> twist;
    std::array<int, kTopics> written_to{};  ///< the MCAP channel and 1; 0: none yet
  };
  struct Told {
    bool any = false;
    std::int64_t at_ns = 0;
    std::uint64_t codes = 0;
  };

  Bus& BusOf(std::uint8_t channel);
  /// Writes what is in cdr_.
  void Write(Bus& from, Topic topic, std::int64_t time_ns);
  void TakeJoint(Bus& bus, Joints& joints, int node, std::int64_t time_ns, double position_rad,
                 double velocity_radps);
  void EndJoints(Bus& bus, Joints& joints);
  void TakeOdometer(Bus& bus, const can::BaseOdometer& odometer, std::int64_t time_ns);
  void Diagnose(Bus& bus, const LogFrame& frame);
  void DiagnoseError(Bus& bus, const LogFrame& frame);

  RosTopics& to_;
  const ChannelNames& channels_;
  const ControlModes& modes_;
  CdrWriter cdr_;
  std::vector<std::unique_ptr<Bus>> buses_;  ///< in the order in which they were met
  IdTable<Told> told_;
  std::vector<std::pair<std::string, std::string>> values_;
};

}  // namespace pipewright::hil
