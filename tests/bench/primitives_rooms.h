// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "hil/sensors/depth_camera.h"
#include "hil/world/scenario.h"
#include "perception/cloud/cloud.h"
#include "platform/core/rng.h"

namespace pipewright::bench {

/// A depth camera in rooms with pipes, both drawn anew again and again.
struct FrameCase {
  const char* name;
  hil::CameraSpec camera;
  int stride;        ///< of MakeCloud
  double room_lo_m;  ///< half the room's width and depth, drawn between these
  double room_hi_m;
  double near_m;  ///< the camera's distance from a pipe's surface, drawn between these
  double far_m;
};

struct TruePlane {
  Vector3d n_W;
  double d_m;
};
struct TruePipe {
  Vector3d p_W;
  Vector3d l_W;
  double radius_m;
};

struct Room {
  std::vector<hil::Solid> solids;
  std::vector<TruePlane> planes;
  std::vector<TruePipe> pipes;
  Vector3d half_m = Vector3d::Zero();
};

/// Rooms, poses and the camera in them; each frame is new.
class FrameSource {
 public:
  FrameSource(const FrameCase& c, std::uint64_t seed) : case_(c), rng_(seed, 7), seed_(seed) {}

  void Next(DepthFrame& frame);
  const Room& room() const { return room_; }
  const Isometry3d& X_WS() const { return X_WS_; }

 private:
  FrameCase case_;
  Rng rng_;
  std::uint64_t seed_;
  std::uint64_t count_ = 0;
  Room room_;
  std::unique_ptr<hil::DepthCamera> camera_;
  Isometry3d X_WS_ = Isometry3d::Identity();
};

}  // namespace pipewright::bench
