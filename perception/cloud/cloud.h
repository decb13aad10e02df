// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "platform/core/depth_frame.h"
#include "platform/core/frames.h"
#include "platform/core/status.h"

namespace pipewright {

/// The readings of one depth frame that can be trusted, organised as the image was.
struct Cloud {
  static constexpr int kMaxPoints = 424 * 240;

  Time stamp{};
  Isometry3d X_WS = Isometry3d::Identity();
  int width = 0;
  int height = 0;
  std::array<Eigen::Vector3f, kMaxPoints> p_SQ;  ///< row-major; only where valid
  std::array<std::uint8_t, kMaxPoints> valid{};
  int valid_count = 0;

  int size() const { return width * height; }
};

/// A box that holds a part of the robot itself: axes of G, centred at G.
struct SelfBox {
  static constexpr int kMax = 32;

  Isometry3d X_WG = Isometry3d::Identity();
  Vector3d half_m = Vector3d::Zero();
};

struct CloudConfig {
  int stride = 1;                     ///< every stride-th pixel of every stride-th row is kept
  double self_margin_m = 0.03;        ///< a point this near to the robot's own body is the robot
  double neighbour_tolerance = 0.03;  ///< share of depth by which neighbours on a surface differ
  int min_neighbours = 3;             ///< of 8; a reading with fewer on its surface is a speckle
};

constexpr bool Valid(const CloudConfig& c) {
  return c.stride >= 1 && c.self_margin_m >= 0 && c.neighbour_tolerance > 0 &&
         0 <= c.min_neighbours && c.min_neighbours <= 8;
}

/// Why readings of a frame were left out.
struct CloudCounts {
  int no_reading = 0;
  int below_minimum_range = 0;
  int beyond_maximum_range = 0;
  int speckle = 0;
  int self = 0;
};

/// Depth frame -> points in S: drops readings out of the camera's range (below the minimum they are
/// wrong, not just noisy), speckles, and what the camera sees of the robot itself.
///
/// @param X_WS  camera pose at the middle of the exposure
/// @param body  the robot's boxes at that time, at most SelfBox::kMax
/// @returns kMalformed when the frame's size or intrinsics make no sense, kFull when the decimated
///          image exceeds Cloud::kMaxPoints or the body kMax boxes; the cloud is then empty.
/// Cost: O(pixels kept * boxes near the point).
Status MakeCloud(const DepthFrame& frame, const Isometry3d& X_WS, std::span<const SelfBox> body,
                 const CloudConfig& config, Cloud& cloud, CloudCounts& counts);

}  // namespace pipewright
