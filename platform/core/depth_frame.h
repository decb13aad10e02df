// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "platform/core/time.h"

namespace pipewright {

/// Pinhole without distortion; the ray of pixel (u, v) is ((u - cx)/fx, (v - cy)/fy, 1) in S.
struct CameraIntrinsics {
  int width = 0;
  int height = 0;
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;
  double z_min_m = 0;  ///< readings nearer than this are wrong, not just noisy
  double z_max_m = 0;  ///< readings farther than this are not used

  friend constexpr bool operator==(const CameraIntrinsics&, const CameraIntrinsics&) = default;
};

/// One depth image as the device sends it (Z16): depth along z_S in millimetres, 0 is no reading.
struct DepthFrame {
  static constexpr int kMaxPixels = 848 * 480;

  Time stamp{};  ///< middle of the exposure
  std::uint32_t sequence = 0;
  CameraIntrinsics camera;
  std::array<std::uint16_t, kMaxPixels> depth_mm{};  ///< row-major, width * height used
};

}  // namespace pipewright
