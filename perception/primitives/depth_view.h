// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "perception/cloud/cloud.h"
#include "perception/primitives/config.h"
#include "perception/primitives/four_floats.h"

namespace pipewright {

/// An organised cloud as rays and inverse depths, in which planes are linear and noise is even.
/// Images of more than kMaxPixels are thinned. ~0.5 MB, no heap.
class DepthView {
 public:
  static constexpr int kMaxPixels = 212 * 120;

  /// Kind of each pixel.
  enum class Use : std::uint8_t { kNone, kFree, kPlane, kPipe };

  /// @returns kMalformed for a size that makes no sense, or readings that no pinhole gives.
  Status Set(const Cloud& cloud, const DepthNoise& noise);

  int width() const { return width_; }
  int height() const { return height_; }
  int size() const { return width_ * height_; }
  const Isometry3d& X_WS() const { return X_WS_; }

  bool seen(int i) const { return inverse_z_[i] > 0; }
  float x(int i) const { return x_[i]; }  ///< the ray (x, y, 1) of a pixel that has a reading
  float y(int i) const { return y_[i]; }
  float inverse_z(int i) const { return inverse_z_[i]; }          ///< 0: no reading
  float inverse_sigma(int i) const { return inverse_sigma_[i]; }  ///< 1/σ(1/z)
  Eigen::Vector3f p_S(int i) const {
    const float z = 1 / inverse_z_[i];
    return {x_[i] * z, y_[i] * z, z};
  }
  float focal() const { return focal_; }  ///< pixels

  // The same of the pixels i ... i + 3; there is room for four at the view's last pixel.
  Floats four_x(int i) const { return Load(&x_[i]); }
  Floats four_y(int i) const { return Load(&y_[i]); }
  Floats four_inverse_z(int i) const { return Load(&inverse_z_[i]); }
  Floats four_inverse_sigma(int i) const { return Load(&inverse_sigma_[i]); }

  Use use(int i) const { return use_[i]; }
  void set_use(int i, Use use) { use_[i] = use; }

  /// Unit normals towards the camera, of the pixels begin ... end − 1 of one row, each by least
  /// squares over the readings about it that lie on its surface; zero where there are too few.
  /// Cost: ~25 ns a pixel.
  void Normals(int begin, int end, Eigen::Vector3f* n_S) const;

 private:
  template <typename T>
  struct NormalSums;
  Eigen::Vector3f Normal(int i, int half) const;
  void FourNormals(int i, int half, Eigen::Vector3f* n_S) const;

  int width_ = 0;
  int height_ = 0;
  float focal_ = 1;
  float c_1pm_ = 0;
  Isometry3d X_WS_ = Isometry3d::Identity();
  std::array<float, kMaxPixels + kLanes> x_{};
  std::array<float, kMaxPixels + kLanes> y_{};
  std::array<float, kMaxPixels + kLanes> inverse_z_{};
  std::array<float, kMaxPixels + kLanes> inverse_sigma_{};
  std::array<Use, kMaxPixels + kLanes> use_{};
};

}  // namespace pipewright
