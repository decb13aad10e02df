// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "hil/devices/device_set.h"
#include "hil/plant/plant.h"
#include "hil/sensors/depth_camera.h"
#include "hil/world/robot_bodies.h"
#include "hil/world/scenario.h"
#include "hil/world/truth.h"
#include "platform/core/depth_frame.h"
#include "platform/core/time.h"

namespace pipewright::hil {

/// The other end of every wire: the devices, the bodies they move, the camera that looks at the
/// world, and the truth of what happened. One scenario, one seed; time is given.
class Emulator {
 public:
  static constexpr Duration kTick = std::chrono::milliseconds(1);

  /// Where the camera and the robot's links are at an instant.
  struct View {
    Time now{};
    Isometry3d X_WS = Isometry3d::Identity();
    std::vector<Isometry3d> X_WL;
  };

  /// @param home_rad  joints at start when the scenario names none
  /// @param ports     one for all devices, or the Tracer's and the arm's; they outlive this
  /// @param tracer    but for its slip, which is the scenario's
  Emulator(const Scenario& scenario, const Vec<kPlantJoints>& home_rad, std::uint64_t seed,
           const std::vector<Port*>& ports, const TracerConfig& tracer = {});

  /// The devices hear, act and answer; then the bodies move for one tick.
  void Step(Time now);

  /// Whether the camera has a frame to give at `now`; then Render() it.
  bool FrameDue(Time now) const;
  void Render(DepthFrame& frame);

  /// The same in two halves, for a camera that is rendered on a thread of its own: Look() belongs
  /// to the thread that steps, the others to the camera's.
  void Look(Time now, View& view);
  bool FrameDue(const View& view) const { return FrameDue(view.now); }
  /// The frame due, or the latest of several: those before it never come. Its stamp is the view's.
  /// @returns how many frames never come
  int Render(const View& view, DepthFrame& frame);

  /// Clearances, contacts and coverage at this instant; once a control cycle.
  const Clearance& Measure(Time now);

  const Plant& plant() const { return plant_; }
  const Truth& truth() const { return truth_; }
  DeviceSet& devices() { return devices_; }
  const DeviceSet& devices() const { return devices_; }
  /// Where the robot stood at the start.
  const BasePose& start() const { return start_; }
  const Vec<kPlantJoints>& start_joints_rad() const { return start_joints_rad_; }
  /// Largest speed of the base across its heading that any tick has shown. [m/s]
  double lateral_speed_max_mps() const { return lateral_speed_max_mps_; }
  double base_travel_m() const { return base_travel_m_; }
  double joint_travel_rad() const { return joint_travel_rad_; }  ///< sum over the joints

 private:
  void Spill(Time now);
  std::span<const Isometry3d> Links();

  Scenario scenario_;
  RobotBodies robot_;
  BasePose start_;
  Vec<kPlantJoints> start_joints_rad_;
  Plant plant_;
  DeviceSet devices_;
  DepthCamera camera_;
  Truth truth_;
  std::optional<Time> camera_silent_from_;
  std::vector<Isometry3d> links_;
  Time next_cover_{};
  double lateral_speed_max_mps_ = 0;
  double base_travel_m_ = 0;
  double joint_travel_rad_ = 0;
};

}  // namespace pipewright::hil
