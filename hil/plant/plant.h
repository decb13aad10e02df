// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <memory>
#include <string_view>
#include <vector>

#include "hil/plant/robot_description.h"
#include "platform/core/frames.h"
#include "platform/core/time.h"

namespace pipewright::hil {

/// The arm joints the plant moves: those of tracer_uf7.urdf.
inline constexpr int kPlantJoints = 7;

/// Where the base stands: the pose of B in W, on the floor.
struct BasePose {
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
};

/// The robot's bodies as they really move. Kinematics by Orocos KDL from the URDF: nothing here is
/// shared with the controller's model.
///
/// The base follows the differential drive's circular arc exactly (no lateral speed by form); the
/// joints integrate their velocities. A joint that reaches a limit of the URDF stops there: the
/// hard stop, counted once a touch.
class Plant {
 public:
  /// Joints outside their limits are put on them. The description must have kPlantJoints moving
  /// joints and links named camera and probe (else assert).
  Plant(const RobotDescription& description, const BasePose& start,
        const Vec<kPlantJoints>& joints_rad);
  ~Plant();
  Plant(Plant&&) noexcept;
  Plant& operator=(Plant&&) noexcept;

  /// Moves for dt at constant v, omega and joint velocities:
  ///   chord = v dt sinc(omega dt / 2) along yaw + omega dt / 2
  /// Non-finite inputs count as zero.
  void Step(Duration dt, double v_mps, double omega_radps, const Vec<kPlantJoints>& qdot_radps);

  int link_count() const;
  /// -1: no such link. Indices are those of RobotDescription::links.
  int LinkIndex(std::string_view link) const;
  /// Poses are computed at the first call after a Step (all links at once, about 1 us).
  const Isometry3d& X_WL(int link) const;
  Isometry3d X_WB() const;
  const Isometry3d& X_WS() const;
  Vector3d p_WP() const;

  const BasePose& base() const { return base_; }
  const Vec<kPlantJoints>& joints_rad() const { return joints_rad_; }
  const Vec<kPlantJoints>& lower_rad() const { return lower_rad_; }
  const Vec<kPlantJoints>& upper_rad() const { return upper_rad_; }
  /// How often joint i (0-based) ran into a hard stop.
  int hard_stops(int joint) const { return hard_stops_[joint]; }
  int hard_stops() const;

 private:
  struct Chain;  // KDL's segments and the poses last computed

  void UpdatePoses() const;

  std::unique_ptr<Chain> chain_;
  BasePose base_;
  Vec<kPlantJoints> joints_rad_;
  Vec<kPlantJoints> lower_rad_;
  Vec<kPlantJoints> upper_rad_;
  std::array<int, kPlantJoints> hard_stops_{};
  std::array<bool, kPlantJoints> at_stop_{};
};

}  // namespace pipewright::hil
