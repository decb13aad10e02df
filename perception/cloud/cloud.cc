// SPDX-License-Identifier: MIT
#include "perception/cloud/cloud.h"

#include <cmath>

#include "platform/core/fixed_vector.h"

namespace pipewright {
namespace {

bool MakesSense(const CameraIntrinsics& c) {
  return c.width > 0 && c.height > 0 && c.width <= DepthFrame::kMaxPixels / c.height &&
         std::isfinite(c.fx) && std::isfinite(c.fy) && c.fx > 0 && c.fy > 0 &&
         std::isfinite(c.cx) && std::isfinite(c.cy) && c.z_min_m >= 0 && c.z_max_m > c.z_min_m;
}

/// Whether enough of a reading's eight neighbours lie on its surface.
bool HasSupport(const DepthFrame& frame, int u, int v, const CloudConfig& config) {
  const int width = frame.camera.width;
  const int height = frame.camera.height;
  const int z_mm = frame.depth_mm[v * width + u];
  const double tolerance_mm = config.neighbour_tolerance * z_mm + 2;
  int support = 0;
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      if ((du == 0 && dv == 0) || u + du < 0 || u + du >= width || v + dv < 0 || v + dv >= height) {
        continue;
      }
      const int other_mm = frame.depth_mm[(v + dv) * width + u + du];
      support += other_mm != 0 && std::abs(other_mm - z_mm) <= tolerance_mm;
    }
  }
  return support >= config.min_neighbours;
}

/// A box of the robot's body, grown by the margin, with the ball about it for a quick no.
struct BoxInSensor {
  Eigen::Isometry3f X_GS;
  Eigen::Vector3f half_m;
  float r2_m2 = 0;
};

using Boxes = FixedVector<BoxInSensor, SelfBox::kMax>;

bool IsSelf(const Eigen::Vector3f& p_SQ, const Boxes& boxes) {
  for (const BoxInSensor& box : boxes) {
    const Eigen::Vector3f p_GQ = box.X_GS * p_SQ;
    if (p_GQ.squaredNorm() <= box.r2_m2 && (p_GQ.array().abs() <= box.half_m.array()).all()) {
      return true;
    }
  }
  return false;
}

}  // namespace

Status MakeCloud(const DepthFrame& frame, const Isometry3d& X_WS, std::span<const SelfBox> body,
                 const CloudConfig& config, Cloud& cloud, CloudCounts& counts) {
  const CameraIntrinsics& camera = frame.camera;
  cloud.stamp = frame.stamp;
  cloud.X_WS = X_WS;
  cloud.width = cloud.height = cloud.valid_count = 0;
  if (!Valid(config) || !MakesSense(camera) || !X_WS.matrix().allFinite()) {
    return Status::kMalformed;
  }
  const int width = camera.width / config.stride;
  const int height = camera.height / config.stride;
  if (width * height > Cloud::kMaxPoints) {
    return Status::kFull;
  }
  Boxes boxes;
  for (const SelfBox& part : body) {
    const Vector3d half_m = part.half_m.array() + config.self_margin_m;
    if (!boxes.push_back({(part.X_WG.inverse() * X_WS).cast<float>(), half_m.cast<float>(),
                          static_cast<float>(half_m.squaredNorm())})) {
      return Status::kFull;
    }
  }
  cloud.width = width;
  cloud.height = height;

  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const int u = column * config.stride + config.stride / 2;
      const int v = row * config.stride + config.stride / 2;
      const int i = row * width + column;
      cloud.valid[i] = 0;
      const double z_m = 1e-3 * frame.depth_mm[v * camera.width + u];
      if (z_m == 0) {
        ++counts.no_reading;
      } else if (z_m < camera.z_min_m) {
        ++counts.below_minimum_range;
      } else if (z_m > camera.z_max_m) {
        ++counts.beyond_maximum_range;
      } else if (!HasSupport(frame, u, v, config)) {
        ++counts.speckle;
      } else {
        const Eigen::Vector3f p_SQ =
            Vector3d{(u - camera.cx) / camera.fx * z_m, (v - camera.cy) / camera.fy * z_m, z_m}
                .cast<float>();
        if (IsSelf(p_SQ, boxes)) {
          ++counts.self;
          continue;
        }
        cloud.p_SQ[i] = p_SQ;
        cloud.valid[i] = 1;
        ++cloud.valid_count;
      }
    }
  }
  return Status::kOk;
}

}  // namespace pipewright
