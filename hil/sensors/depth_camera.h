// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "hil/world/ray_scene.h"
#include "hil/world/robot_bodies.h"
#include "hil/world/scenario.h"
#include "platform/core/depth_frame.h"

namespace pipewright::hil {

/// A RealSense D455 by ray tracing: what the host would get from the device.
///
/// Depth along z_S, in millimetres, of the nearest surface of the world or of the robot's own
/// bodies:
///   noise      z + N(0, (c z^2)^2), c = CameraSpec::noise_sigma_at_1m, then rounded to 1 mm
///   too near   z < z_min: no reading, or (a share) a wrong one: half of these the depth of a
///   random
///              disparity, z_min 126 / d, half off by up to 40 % to either side
///   lost       a share of the frames
///   none (0)   beyond z_max; a share anywhere; half of the pixels beside a jump in depth of more
///   than
///              0.05 m + 0.05 z; at grazing angles, surely at cos < 0.05, never at cos > 0.2
///
/// Noise is a hash of (seed, sequence, pixel): the same seed gives the same frames.
class DepthCamera {
 public:
  /// The robot's bodies are copied; solids are attached as they are.
  DepthCamera(const CameraSpec& spec, const std::vector<Solid>& solids, const RobotBodies& robot,
              std::uint64_t seed);

  const CameraIntrinsics& intrinsics() const { return intrinsics_; }

  /// The stamp of the next frame: sequence / rate. A caller renders when it has come. A frame that
  /// is lost has its sequence number, too.
  Time next_stamp() const;

  /// Passes over frames that nobody rendered in time, as long as the one after them is due at
  /// `now`, too. @returns how many
  int PassDueBefore(Time now);

  /// Renders the next frame, seen from X_WS with the robot's links at X_WL. Some 2 ms of one core.
  void Render(const Isometry3d& X_WS, std::span<const Isometry3d> X_WL, DepthFrame& frame);

  /// The exact depth [m] along z_S for each pixel (infinity: nothing) and the cosine between ray
  /// and surface normal; what Render starts from.
  struct ExactPixel {
    float z_m = 0;
    float cosine = 0;
    int solid = -1;  ///< index of the solid, or solids + index of the robot's body, or -1
  };
  const std::vector<ExactPixel>& Trace(const Isometry3d& X_WS, std::span<const Isometry3d> X_WL);

 private:
  ExactPixel PixelOf(float z_m, std::uint32_t geometry, std::uint32_t instance, Eigen::Vector3f n,
                     const Eigen::Vector3f& d_W) const;
  double TooNear(double z_m, std::uint64_t bits) const;
  bool MaySee(const Vector3d& center_S, double radius_m) const;
  void PlaceRobot(const Isometry3d& X_WS, std::span<const Isometry3d> X_WL);
  std::uint16_t Read(int pixel, std::uint64_t frame_key) const;
  bool BesideJump(int pixel) const;
  void PassLost();

  CameraSpec spec_;
  CameraIntrinsics intrinsics_;
  std::uint64_t seed_;
  std::uint32_t sequence_ = 0;
  std::vector<Body> bodies_;
  std::vector<Eigen::Matrix3f> R_WG_;  ///< of the robot's bodies, as last placed
  int solids_ = 0;
  RayDevice device_;
  std::deque<RayGeometry> body_scenes_;
  RayGeometry scene_;
  std::vector<ExactPixel> exact_;
};

}  // namespace pipewright::hil
