// SPDX-License-Identifier: MIT
#include "hil/emulator/emulator.h"

#include <algorithm>
#include <cmath>

namespace pipewright::hil {
namespace {

constexpr Duration kCoverPeriod = std::chrono::milliseconds(50);

Vec<kPlantJoints> JointsOf(const StartPose& start, const Vec<kPlantJoints>& home_rad) {
  if (start.joints_rad.empty()) {
    return home_rad;
  }
  return Eigen::Map<const Vec<kPlantJoints>>(start.joints_rad.data());
}

Time FaultTime(const ScheduledFault& fault) {
  return fault.kind == FaultKind::kAbsent ? Time{} : Time{FromSeconds(fault.at_s)};
}

/// A device that is to fall silent twice has nothing more to say after the first time.
void Silence(const ScheduledFault& fault, std::optional<Time>& from) {
  from = std::min(from.value_or(Time::max()), FaultTime(fault));
}

DeviceSetConfig Devices(const Plant& plant, const Scenario& scenario, std::uint64_t seed,
                        const TracerConfig& tracer) {
  DeviceSetConfig config = TracerUf7Devices(plant.lower_rad(), plant.upper_rad());
  config.tracer = tracer;
  const BaseSpec& base = scenario.base;
  config.tracer.slip = {.yaw_scale_slow = base.yaw_scale_slow,
                        .yaw_scale_fast = base.yaw_scale_fast,
                        .slip = base.slip,
                        .slip_sigma = base.slip_sigma,
                        .seed = seed};
  for (const ScheduledFault& fault : scenario.faults) {
    const int device = DeviceNumber(fault.device);
    if (device < 0 || fault.kind == FaultKind::kSlip) {
      continue;  // the camera's, and what Emulator::Spill does
    }
    if (fault.kind == FaultKind::kAbsent) {
      config.absent[device] = true;
    } else {
      Silence(fault, config.silent_from[device]);
    }
  }
  return config;
}

}  // namespace

Emulator::Emulator(const Scenario& scenario, const Vec<kPlantJoints>& home_rad, std::uint64_t seed,
                   const std::vector<Port*>& ports, const TracerConfig& tracer)
    : scenario_(scenario),
      robot_(RobotBodiesOf(TracerUf7Description())),
      start_{scenario.start.x_m, scenario.start.y_m, scenario.start.yaw_rad},
      start_joints_rad_(JointsOf(scenario.start, home_rad)),
      plant_(TracerUf7Description(), start_, start_joints_rad_),
      devices_(Devices(plant_, scenario, seed, tracer), ports),
      camera_(scenario.camera, scenario_.solids, robot_, seed),
      truth_(scenario_, robot_) {
  for (const ScheduledFault& fault : scenario.faults) {
    if (fault.device == "camera") {
      Silence(fault, camera_silent_from_);
    }
  }
}

/// The floor's wet places, by the time at which the robot gets there.
void Emulator::Spill(Time now) {
  const double now_s = ToSeconds(now);
  double left = 0;
  double right = 0;
  for (const ScheduledFault& fault : scenario_.faults) {
    if (fault.kind == FaultKind::kSlip && now_s >= fault.at_s && now_s < fault.at_s + fault.for_s) {
      left += fault.left;
      right += fault.right;
    }
  }
  devices_.tracer().Spill(left, right);
}

void Emulator::Step(Time now) {
  Spill(now);
  const DeviceMotion motion = devices_.Step(now, plant_.joints_rad());
  const BasePose before = plant_.base();
  const Vec<kPlantJoints> joints = plant_.joints_rad();
  plant_.Step(kTick, motion.base.v_mps, motion.base.omega_radps, motion.joints_radps);

  const BasePose& after = plant_.base();
  const double heading = (before.yaw_rad + after.yaw_rad) / 2;
  const double dx = after.x_m - before.x_m;
  const double dy = after.y_m - before.y_m;
  const double lateral = std::abs(-std::sin(heading) * dx + std::cos(heading) * dy);
  lateral_speed_max_mps_ = std::max(lateral_speed_max_mps_, lateral / ToSeconds(kTick));
  base_travel_m_ += std::hypot(dx, dy);
  joint_travel_rad_ += (plant_.joints_rad() - joints).cwiseAbs().sum();
}

bool Emulator::FrameDue(Time now) const {
  return now >= camera_.next_stamp() && !(camera_silent_from_ && now >= *camera_silent_from_);
}

std::span<const Isometry3d> Emulator::Links() {
  links_.resize(static_cast<std::size_t>(plant_.link_count()));
  for (int i = 0; i < plant_.link_count(); ++i) {
    links_[static_cast<std::size_t>(i)] = plant_.X_WL(i);
  }
  return links_;
}

void Emulator::Render(DepthFrame& frame) { camera_.Render(plant_.X_WS(), Links(), frame); }

void Emulator::Look(Time now, View& view) {
  view.now = now;
  view.X_WS = plant_.X_WS();
  const std::span<const Isometry3d> links = Links();
  view.X_WL.assign(links.begin(), links.end());
}

int Emulator::Render(const View& view, DepthFrame& frame) {
  const int passed = camera_.PassDueBefore(view.now);
  camera_.Render(view.X_WS, view.X_WL, frame);
  frame.stamp = view.now;
  return passed;
}

const Clearance& Emulator::Measure(Time now) {
  if (now >= next_cover_) {
    next_cover_ = now + kCoverPeriod;
    truth_.Cover(plant_.p_WP());
  }
  return truth_.Measure(Links());
}

}  // namespace pipewright::hil
