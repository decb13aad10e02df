// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <limits>

#include "perception/primitives/fit.h"
#include "perception/primitives/four_floats.h"

namespace pipewright {

/// A cylinder without ends, in single precision: it only chooses.
struct PipeAxis {
  explicit PipeAxis(const CylinderFit& pipe)
      : p_S(pipe.p_S.cast<float>()),
        l_S(pipe.l_S.cast<float>()),
        radius_m(static_cast<float>(pipe.radius_m)) {}
  Eigen::Vector3f p_S;
  Eigen::Vector3f l_S;
  float radius_m;
};

/// Readings with normals, each kind of number beside its like: a pipe is asked of four at a time.
template <int room>
class PipeReadings {
 public:
  int size() const { return size_; }
  void clear() { size_ = 0; }
  /// @param sigma_per_m  σ(z)/z: times |g'p|, the noise across a surface with normal g
  void push_back(const Eigen::Vector3f& p_S, const Eigen::Vector3f& n_S, float sigma_per_m) {
    Set(size_++, p_S, n_S, sigma_per_m);
  }
  void push_back(const auto& other, int k) {
    push_back(other.p_S(k), other.n_S(k), other.sigma_per_m(k));
  }
  /// To be called after the last push_back(): the readings that fill up the last four agree with
  /// nothing.
  void Close() {
    constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
    for (int k = size_; k < size_ + kLanes; ++k) {
      Set(k, Eigen::Vector3f::Constant(kNaN), Eigen::Vector3f::Zero(), 0);
    }
  }

  Eigen::Vector3f p_S(int k) const { return {x_[k], y_[k], z_[k]}; }
  Eigen::Vector3f n_S(int k) const { return {nx_[k], ny_[k], nz_[k]}; }
  float sigma_per_m(int k) const { return sigma_per_m_[k]; }

  /// Which of the readings k ... k + 3 lie within `sigmas` of their noise of a pipe and face as it
  /// does; where along its axis they are.
  Masks Agree(int k, const PipeAxis& axis, float sigmas, Floats& s_m) const {
    constexpr float kReach_m = 1.5F;       // along the axis from a hypothesis' middle
    constexpr float kNormalAgrees = 0.6F;  // cosine
    constexpr float kSlack_m = 0.001F;     // pipes are round to this
    constexpr float kFar_m = 0.1F;
    const Across at = Cross(k, axis);
    s_m = at.s_m;
    const Floats facing = Load(&nx_[k]) * at.x + Load(&ny_[k]) * at.y + Load(&nz_[k]) * at.z;
    const Floats along_ray =
        at.x * Load(&x_[k]) + at.y * Load(&y_[k]) + at.z * Load(&z_[k]);  // times ρ
    const Floats off_m = Absolute(at.rho_m - axis.radius_m);
    const Floats towards =
        Greater(Absolute(along_ray), static_cast<float>(kGrazing) * Load(&length_m_[k]) * at.rho_m);
    return (Absolute(at.s_m) <= kReach_m) & (at.rho_m >= 1e-6F) & (off_m <= kFar_m) &
           (facing >= kNormalAgrees * at.rho_m) &
           ((off_m - kSlack_m) * at.rho_m < sigmas * Load(&sigma_per_m_[k]) * towards);
  }

  /// Which of the readings k ... k + 3 lie between lo and hi of a pipe's axis and within `sigmas`
  /// of their noise along the ray, and `least_m` more, of its surface.
  Masks Near(int k, const PipeAxis& axis, float lo_m, float hi_m, float sigmas,
             float least_m) const {
    const Across at = Cross(k, axis);
    const Floats limit_m = sigmas * Load(&length_m_[k]) * Load(&sigma_per_m_[k]) + least_m;
    return (at.s_m > lo_m) & (at.s_m < hi_m) & (Absolute(at.rho_m - axis.radius_m) < limit_m);
  }

 private:
  /// Where four readings are in a pipe: along its axis, across it, and how far from it.
  struct Across {
    Floats s_m;
    Floats x, y, z;
    Floats rho_m;
  };
  Across Cross(int k, const PipeAxis& axis) const {
    const Floats x = Load(&x_[k]) - axis.p_S.x();
    const Floats y = Load(&y_[k]) - axis.p_S.y();
    const Floats z = Load(&z_[k]) - axis.p_S.z();
    Across at;
    at.s_m = axis.l_S.x() * x + axis.l_S.y() * y + axis.l_S.z() * z;
    at.x = x - at.s_m * axis.l_S.x();
    at.y = y - at.s_m * axis.l_S.y();
    at.z = z - at.s_m * axis.l_S.z();
    at.rho_m = SquareRoot(at.x * at.x + at.y * at.y + at.z * at.z);
    return at;
  }
  void Set(int k, const Eigen::Vector3f& p_S, const Eigen::Vector3f& n_S, float sigma_per_m) {
    x_[k] = p_S.x(), y_[k] = p_S.y(), z_[k] = p_S.z();
    nx_[k] = n_S.x(), ny_[k] = n_S.y(), nz_[k] = n_S.z();
    sigma_per_m_[k] = sigma_per_m;
    length_m_[k] = std::sqrt(p_S.squaredNorm());
  }

  using Column = std::array<float, room + kLanes>;
  int size_ = 0;
  Column x_, y_, z_, nx_, ny_, nz_, sigma_per_m_, length_m_;
};

}  // namespace pipewright
