// SPDX-License-Identifier: MIT
#include "hil/cli/can_to_ros.h"

#include <fmt/format.h>

#include <algorithm>

#include "hil/canlog/error_message.h"
#include "hil/canlog/frame_decoder.h"
#include "hil/cli/canlog_signals.h"
#include "platform/can/cia402_state.h"

namespace pipewright::hil {
namespace {

constexpr std::int64_t kToldAgain_ns = 1'000'000'000;

struct TopicKind {
  const char* name;
  const RosType* type;
};
const TopicKind kTopicKinds[] = {
    {"joint_states", &kRosJointState}, {"joint_commands", &kRosJointState},
    {"odom", &kRosOdometry},           {"tf", &kRosTransforms},
    {"cmd_vel", &kRosTwistStamped},    {"diagnostics", &kRosDiagnostics},
};

/// As the URDF names them.
const std::array<std::string, can::kArmNodes> kJointNames = {"joint1", "joint2", "joint3", "joint4",
                                                             "joint5", "joint6", "joint7"};

bool IsDiagnostic(std::string_view frame) {
  constexpr std::string_view kFrames[] = {"base_state", "base_motor_slow",    "base_battery",
                                          "emergency",  "tpdo2_joint_status", "heartbeat"};
  return std::find(std::begin(kFrames), std::end(kFrames), frame) != std::end(kFrames);
}

double Value(const DecodedFrame& frame, std::string_view signal) {
  for (const SignalValue& one : frame.signals) {
    if (one.name == signal) {
      return one.value;
    }
  }
  return 0;
}

std::uint32_t Code(const DecodedFrame& frame, std::string_view signal) {
  return static_cast<std::uint32_t>(Value(frame, signal));
}

RosLevel BaseLevel(const DecodedFrame& frame) {
  const std::uint32_t errors = Code(frame, "errors");
  const bool normal =
      Code(frame, "vehicle_state") == static_cast<std::uint32_t>(can::VehicleState::kNormal);
  if (normal && errors == 0) {
    return RosLevel::kOk;
  }
  const std::uint32_t warnings =
      can::base_error::kUndervoltageWarning | can::base_error::kRemoteLost;
  return normal && (errors & ~warnings) == 0 ? RosLevel::kWarn : RosLevel::kError;
}

RosLevel DriveLevel(std::uint32_t statusword) {
  switch (can::StateOf(statusword)) {
    case can::DriveState::kOperationEnabled:
      return RosLevel::kOk;
    case can::DriveState::kFault:
    case can::DriveState::kFaultReaction:
    case can::DriveState::kUnknown:
      return RosLevel::kError;
    case can::DriveState::kNotReady:
    case can::DriveState::kSwitchOnDisabled:
    case can::DriveState::kReadyToSwitchOn:
    case can::DriveState::kSwitchedOn:
    case can::DriveState::kQuickStopActive:
      break;
  }
  return RosLevel::kWarn;
}

RosLevel LevelOf(const DecodedFrame& frame) {
  const std::string_view name = frame.head->name;
  if (name == "base_state") {
    return BaseLevel(frame);
  }
  if (name == "tpdo2_joint_status") {
    return DriveLevel(Code(frame, "statusword"));
  }
  if (name == "emergency") {
    return Code(frame, "code") == can::emergency::kNone ? RosLevel::kOk : RosLevel::kError;
  }
  if (name == "heartbeat") {
    return Code(frame, "state") == static_cast<std::uint32_t>(can::NmtState::kOperational)
               ? RosLevel::kOk
               : RosLevel::kWarn;
  }
  constexpr std::uint32_t kOverCurrentOrLost = 1U << 2 | 1U << 4;
  return name == "base_motor_slow" && (Code(frame, "driver_state") & kOverCurrentOrLost) != 0
             ? RosLevel::kError
             : RosLevel::kOk;
}

}  // namespace

CanToRos::CanToRos(RosTopics& to, const ChannelNames& channels, const ControlModes& modes)
    : to_(to), channels_(channels), modes_(modes) {}

CanToRos::~CanToRos() = default;

void CanToRos::Take(const LogFrame& frame) {
  Bus& bus = BusOf(frame.channel);
  if (frame.error) {
    DiagnoseError(bus, frame);
    return;
  }
  if (RowOf(frame) < 0) {
    return;
  }
  const std::int64_t ns = frame.stamp_ns;
  can::RxCounters counters;
  static_cast<void>(can::Dispatch(
      kLogTable, ClassicFrame(frame), counters,
      [&]<typename Message>(const can::FrameHead&, const Message& message, int node) {
        if constexpr (std::is_same_v<Message, can::JointFeedback>) {
          TakeJoint(bus, bus.states, node, ns, message.position_rad, message.velocity_radps);
        } else if constexpr (std::is_same_v<Message, can::JointCommand>) {
          TakeJoint(bus, bus.commands, node, ns, 0, message.velocity_radps);
        } else if constexpr (std::is_same_v<Message, can::BaseTwist>) {
          bus.twist = message;
        } else if constexpr (std::is_same_v<Message, can::BaseOdometer>) {
          TakeOdometer(bus, message, ns);
        } else if constexpr (std::is_same_v<Message, can::BaseTwistCommand>) {
          WriteRos(cdr_, RosTwist{{ns, "base_link"}, message.v_mps, message.omega_radps});
          Write(bus, kCmdVel, ns);
        }
      }));
  Diagnose(bus, frame);
}

void CanToRos::End() {
  for (const auto& bus : buses_) {
    EndJoints(*bus, bus->states);
    EndJoints(*bus, bus->commands);
  }
}

CanToRos::Bus& CanToRos::BusOf(std::uint8_t channel) {
  const auto found = std::find_if(buses_.begin(), buses_.end(),
                                  [channel](const auto& bus) { return bus->channel == channel; });
  if (found != buses_.end()) {
    return **found;
  }
  buses_.push_back(std::make_unique<Bus>());
  buses_.back()->channel = channel;
  return *buses_.back();
}

void CanToRos::Write(Bus& from, Topic topic, std::int64_t time_ns) {
  Bus& bus = topic == kDiagnostics ? *buses_.front() : from;  // they tell of which bus they are
  int& channel = bus.written_to[topic];
  if (channel == 0) {
    const TopicKind& kind = kTopicKinds[topic];
    const bool first = std::none_of(buses_.begin(), buses_.end(), [topic](const auto& other) {
      return other->written_to[topic] != 0;
    });
    std::string name = first ? "" : fmt::format("/{}", channels_.Name(bus.channel));
    name += fmt::format("/{}", kind.name);
    channel = to_.Channel(name, *kind.type) + 1;
  }
  to_.Write(static_cast<std::uint16_t>(channel - 1), time_ns, cdr_);
}

void CanToRos::TakeJoint(Bus& bus, Joints& joints, int node, std::int64_t time_ns,
                         double position_rad, double velocity_radps) {
  const auto joint = static_cast<std::size_t>(node - 1);
  if (joints.have[joint]) {
    EndJoints(bus, joints);
  }
  joints.have[joint] = true;
  joints.position_rad[joint] = position_rad;
  joints.velocity_radps[joint] = velocity_radps;
  joints.last_ns = time_ns;
  if (std::all_of(joints.have.begin(), joints.have.end(), [](bool have) { return have; })) {
    EndJoints(bus, joints);
  }
}

void CanToRos::EndJoints(Bus& bus, Joints& joints) {
  std::array<std::string, can::kArmNodes> names;
  std::array<double, can::kArmNodes> position_rad{};
  std::array<double, can::kArmNodes> velocity_radps{};
  std::size_t count = 0;
  for (std::size_t joint = 0; joint < joints.have.size(); ++joint) {
    if (joints.have[joint]) {
      names[count] = kJointNames[joint];
      position_rad[count] = joints.position_rad[joint];
      velocity_radps[count++] = joints.velocity_radps[joint];
    }
  }
  joints.have = {};
  if (count == 0) {
    return;
  }
  const std::span<const double> positions(position_rad);
  WriteRos(cdr_, RosJointState{{joints.last_ns, ""},
                               std::span(names).first(count),
                               positions.first(joints.with_position ? count : 0),
                               std::span(velocity_radps).first(count)});
  Write(bus, joints.topic, joints.last_ns);
}

void CanToRos::TakeOdometer(Bus& bus, const can::BaseOdometer& odometer, std::int64_t time_ns) {
  if (!bus.twist) {
    return;
  }
  const Status status =
      bus.odometry.Step(Time(Duration(time_ns)), bus.twist->v_mps, bus.twist->omega_radps,
                        odometer.left_m, odometer.right_m);
  if (status != Status::kOk && status != Status::kFault) {
    return;  // a stamp that is not newer than the last
  }
  const BasePose& pose = bus.odometry.pose();
  RosOdometry message{.header = {time_ns, "odom"},
                      .child_frame = "base_link",
                      .x_m = pose.x_m,
                      .y_m = pose.y_m,
                      .yaw_rad = pose.phi_rad,
                      .v_mps = bus.twist->v_mps,
                      .omega_radps = bus.twist->omega_radps};
  std::copy_n(pose.covariance.data(), message.covariance.size(), message.covariance.begin());
  WriteRos(cdr_, message);
  Write(bus, kOdom, time_ns);
  WriteRosTransform(cdr_, message);
  Write(bus, kTf, time_ns);
}

void CanToRos::Diagnose(Bus& bus, const LogFrame& frame) {
  DecodedFrame decoded;
  if (DecodeFrame(frame, decoded) != Status::kOk || !IsDiagnostic(decoded.head->name)) {
    return;
  }
  std::uint64_t codes = 0;
  for (const SignalValue& signal : decoded.signals) {
    if (signal.has_name()) {
      codes = codes << 16 | static_cast<std::uint64_t>(signal.value);
    }
  }
  Told* const told = told_.Find(KeyOf(frame));
  if (told == nullptr ||
      (told->any && told->codes == codes && frame.stamp_ns - told->at_ns < kToldAgain_ns)) {
    return;
  }
  *told = {true, frame.stamp_ns, codes};
  values_.clear();
  std::string words;
  for (const SignalValue& signal : decoded.signals) {
    fmt::memory_buffer text;
    if (signal.has_name()) {
      signal.append_name(text, static_cast<std::uint32_t>(signal.value), modes_);
      words +=
          fmt::format("{}{}: {}", words.empty() ? "" : "; ", signal.name, fmt::to_string(text));
    } else {
      AppendValue(text, signal.value);
    }
    const std::string unit = signal.unit == "1" ? "" : fmt::format(" [{}]", signal.unit);
    values_.emplace_back(fmt::format("{}{}", signal.name, unit), fmt::to_string(text));
  }
  const std::string hardware =
      fmt::format("{} on {}", decoded.head->name.starts_with("base_") ? "tracer" : "uf7",
                  channels_.Name(bus.channel));
  WriteRos(cdr_, RosDiagnostic{.header = {frame.stamp_ns, ""},
                               .level = LevelOf(decoded),
                               .name = FrameName(KeyOf(frame)),
                               .message = words,
                               .hardware = hardware,
                               .values = values_});
  Write(bus, kDiagnostics, frame.stamp_ns);
}

void CanToRos::DiagnoseError(Bus& bus, const LogFrame& frame) {
  fmt::memory_buffer words;
  AppendErrorMessage(words, frame);
  const std::string text = fmt::to_string(words);
  WriteRos(cdr_, RosDiagnostic{.header = {frame.stamp_ns, ""},
                               .level = RosLevel::kError,
                               .name = "CAN controller",
                               .message = text,
                               .hardware = channels_.Name(bus.channel),
                               .values = {}});
  Write(bus, kDiagnostics, frame.stamp_ns);
}

}  // namespace pipewright::hil
