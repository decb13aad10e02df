// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

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
using RayScenePtr = std::unique_ptr<RTCSceneTy, RaySceneRelease>;

/// One Embree device without worker threads.
RayDevice NewRayDevice();
RayScenePtr NewRayScene(RTCDeviceTy* device);

/// Adds a convex shape (box, cylinder, sphere) at X_WG; cylinders and spheres are exact, not
/// facetted.
void AttachShape(RTCDeviceTy* device, RTCSceneTy* scene, const Shape& shape,
                 const Isometry3d& X_WG);
/// Adds a solid of the world. A plane is a square of 100 m about the origin's foot on it.
void AttachSolid(RTCDeviceTy* device, RTCSceneTy* scene, const Solid& solid);

/// The solids of a world, for questions of sight.
class RayScene {
 public:
  explicit RayScene(const std::vector<Solid>& solids);

  /// Whether a solid lies between two points, the last gap_m before `to` left out. About 0.3 us.
  bool Occluded(const Vector3d& from_W, const Vector3d& to_W, double gap_m = 2e-4) const;

 private:
  RayDevice device_;
  RayScenePtr scene_;
};

}  // namespace pipewright::hil
