// SPDX-License-Identifier: MIT
#include "perception/primitives/depth_view.h"

#include <algorithm>
#include <cmath>

namespace pipewright {
namespace {

constexpr float kStep_m = 0.03F;  // neighbours farther apart in depth are two surfaces
constexpr int kMinNeighbours = 5;
constexpr int kWideImage = 160;  // pixels a row, from which normals take 5x5 rather than 3x3
constexpr float kMinZ_m = 0.05F;

}  // namespace

Status DepthView::Set(const Cloud& cloud, const DepthNoise& noise) {
  width_ = height_ = 0;
  c_1pm_ = static_cast<float>(noise.c_1pm);
  if (cloud.width < 4 || cloud.height < 4 || cloud.size() > Cloud::kMaxPoints ||
      !cloud.X_WS.matrix().allFinite()) {
    return Status::kMalformed;
  }
  int step = 1;
  while ((cloud.width / step) * (cloud.height / step) > kMaxPixels) {
    ++step;
  }
  width_ = cloud.width / step;
  height_ = cloud.height / step;
  X_WS_ = cloud.X_WS;
  for (int row = 0; row < height_; ++row) {
    for (int column = 0; column < width_; ++column) {
      const int i = row * width_ + column;
      const int source = row * step * cloud.width + column * step;
      const Eigen::Vector3f& p = cloud.p_SQ[source];
      const bool usable = cloud.valid[source] != 0 && p.allFinite() && p.z() > kMinZ_m;
      use_[i] = usable ? Use::kFree : Use::kNone;
      inverse_z_[i] = usable ? 1 / p.z() : 0;
      x_[i] = usable ? p.x() * inverse_z_[i] : 0;
      y_[i] = usable ? p.y() * inverse_z_[i] : 0;
      inverse_sigma_[i] = usable ? static_cast<float>(1 / noise.SigmaInverse(inverse_z_[i])) : 0;
    }
  }
  // The focal length, from two rays of the widest row.
  focal_ = 0;
  for (int row = 0; row < height_; ++row) {
    int first = row * width_;
    int last = first + width_ - 1;
    const int begin = first;
    while (first < last && !seen(first)) {
      ++first;
    }
    while (last > begin && !seen(last)) {
      --last;
    }
    const float span = first < last ? x_[last] - x_[first] : 0;
    if (span > 0 && last - first >= 4) {
      focal_ = std::max(focal_, static_cast<float>(last - first) / span);
    }
  }
  return focal_ > 0 ? Status::kOk : Status::kMalformed;
}

std::optional<Eigen::Vector3f> DepthView::Normal(int i) const {
  const int half = width_ >= kWideImage ? 2 : 1;
  const int column = i % width_;
  const int row = i / width_;
  const float w0 = inverse_z_[i];
  const float tolerance = kStep_m * w0 * w0 + 4 * c_1pm_;
  float n = 0;
  float sx = 0, sy = 0, sw = 0, sxx = 0, syy = 0, sxy = 0, sxw = 0, syw = 0;
  for (int r = std::max(0, row - half); r <= std::min(height_ - 1, row + half); ++r) {
    for (int c = std::max(0, column - half); c <= std::min(width_ - 1, column + half); ++c) {
      const int j = r * width_ + c;
      const float dw = inverse_z_[j] - w0;
      if (!seen(j) || std::abs(dw) > tolerance) {
        continue;
      }
      const float dx = x_[j] - x_[i];
      const float dy = y_[j] - y_[i];
      n += 1;
      sx += dx, sy += dy, sw += dw;
      sxx += dx * dx, syy += dy * dy, sxy += dx * dy;
      sxw += dx * dw, syw += dy * dw;
    }
  }
  if (n < kMinNeighbours) {
    return std::nullopt;
  }
  sxx -= sx * sx / n, syy -= sy * sy / n, sxy -= sx * sy / n;
  sxw -= sx * sw / n, syw -= sy * sw / n;
  const float determinant = sxx * syy - sxy * sxy;
  if (!(determinant > 0.05F * sxx * syy)) {
    return std::nullopt;
  }
  const float b = (sxw * syy - syw * sxy) / determinant;
  const float g = (syw * sxx - sxw * sxy) / determinant;
  const float a = w0 + (sw - b * sx - g * sy) / n;
  const Eigen::Vector3f m(b, g, a - b * x_[i] - g * y_[i]);
  const float length = std::sqrt(m.squaredNorm());
  if (!(length > 1e-6F)) {
    return std::nullopt;
  }
  return Eigen::Vector3f(-m / length);
}

}  // namespace pipewright
