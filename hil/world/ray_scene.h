// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "hil/world/round_geometry.h"
#include "hil/world/solid.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace pipewright::hil {

struct RayDeviceRelease {
  void operator()(RTCDeviceTy* device) const;
};
struct RaySceneRelease {
  void operator()(RTCSceneTy* scene) const;
};
using RayDevice = std::unique_ptr<RTCDeviceTy, RayDeviceRelease>;

/// One Embree device without worker threads.
RayDevice NewRayDevice();

/// An Embree scene and what its geometries refer to. Geometry ids count from 0 in the order of
/// adding.
class RayGeometry {
 public:
  /// The device must outlive it.
  explicit RayGeometry(RTCDeviceTy* device);

  /// A convex shape at X_WG; cylinders and spheres are exact, not facetted.
  void Add(const Shape& shape, const Isometry3d& X_WG);
  /// A solid of the world. A plane is a square of 100 m about the origin's foot on it.
  void Add(const Solid& solid);

  RTCSceneTy* scene() const { return scene_.get(); }

 private:
  RTCDeviceTy* device_;
  std::deque<RoundShape> rounds_;  ///< a deque: its elements stay where they are
  std::unique_ptr<RTCSceneTy, RaySceneRelease> scene_;
};

/// The solids of a world, for questions of sight.
class RayScene {
 public:
  explicit RayScene(const std::vector<Solid>& solids);

  /// Whether a solid lies between two points, the last gap_m before `to` left out. About 0.3 us.
  bool Occluded(const Vector3d& from_W, const Vector3d& to_W, double gap_m = 2e-4) const;

 private:
  RayDevice device_;
  RayGeometry geometry_;
};

}  // namespace pipewright::hil
