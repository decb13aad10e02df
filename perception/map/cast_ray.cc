// SPDX-License-Identifier: MIT
#include <limits>

#include "perception/map/key_math.h"
#include "perception/map/voxel_grid.h"

namespace pipewright {

/// OctoMap's castRay, step by step, on the flat planes of the grid.
class RayCaster {
 public:
  RayCaster(const VoxelGrid& grid, const Vector3f& origin_W, double max_range_m,
            bool ignore_unknown)
      : grid_(grid),
        origin_(origin_W),
        width_(grid.config_.width_m),
        max_range_(max_range_m),
        ignore_unknown_(ignore_unknown) {
    origin_ok_ = key_math::VoxelOf(origin_W, 1 / width_, &start_);
  }

  RayHit Cast(const Vector3f& direction_W) const {
    RayHit ray{.hit = false, .end = start_};
    const double norm = key_math::Norm(direction_W);
    if (!origin_ok_ || !(norm > 0) || norm > std::numeric_limits<float>::max()) {
      return ray;
    }
    if (Stops(grid_.InBox(start_), grid_.FlatIndex(start_), &ray.hit)) {
      return ray;
    }
    Follow(key_math::Divided(direction_W, static_cast<float>(norm)), &ray);
    return ray;
  }

 private:
  /// Whether a ray ends in a voxel, and whether that is a hit.
  bool Stops(bool in_box, std::int64_t index, bool* hit) const {
    const unsigned code = in_box ? grid_.Code(static_cast<int>(index)) : 0;
    *hit = code == VoxelGrid::kOccupiedCode;
    return *hit || (!ignore_unknown_ && (code & VoxelGrid::kKnown) == 0);
  }

  void Follow(const Vector3f& direction, RayHit* ray) const {
    const int lo[3] = {grid_.config_.lo.x, grid_.config_.lo.y, grid_.config_.lo.z};
    const int n[3] = {grid_.nx_, grid_.ny_, grid_.nz_};
    std::int64_t stride[3] = {1, n[0], std::int64_t{n[0]} * n[1]};
    int at[3] = {start_.x, start_.y, start_.z};
    int step[3] = {};
    double t_next[3];
    double t_delta[3];
    for (int i = 0; i < 3; ++i) {
      const double d = direction[i];
      step[i] = d > 0 ? 1 : d < 0 ? -1 : 0;
      stride[i] *= step[i];
      const double border = key_math::Center(at[i], width_) + step[i] * width_ * 0.5;
      constexpr double kNever = std::numeric_limits<double>::max();
      t_next[i] = d != 0 ? (border - static_cast<double>(origin_[i])) / d : kNever;
      t_delta[i] = d != 0 ? width_ / std::abs(d) : kNever;
    }
    // A voxel entered this early has its centre within the range: no need to compute it.
    const double sure =
        max_range_ > 0 ? max_range_ - 2 * width_ : std::numeric_limits<double>::max();
    const auto in = [&](int i) {
      return static_cast<unsigned>(at[i] - lo[i]) < static_cast<unsigned>(n[i]);
    };
    bool in_box = in(0) && in(1) && in(2);
    for (std::int64_t index = grid_.FlatIndex(start_);;) {
      int axis = t_next[0] < t_next[1] ? 0 : 1;
      axis = t_next[axis] < t_next[2] ? axis : 2;
      if (at[axis] == (step[axis] > 0 ? key_math::kReach - 1 : -key_math::kReach)) {
        break;
      }
      const double entered = t_next[axis];
      at[axis] += step[axis];
      index += stride[axis];
      t_next[axis] += t_delta[axis];
      in_box = in(axis) && (in_box || (in(0) && in(1) && in(2)));
      if ((entered > sure && BeyondRange({at[0], at[1], at[2]})) ||
          Stops(in_box, index, &ray->hit)) {
        break;
      }
    }
    ray->end = {at[0], at[1], at[2]};
  }

  bool BeyondRange(const VoxelIndex& v) const {
    const auto x = static_cast<float>(key_math::Center(v.x, width_)) - origin_.x();
    const auto y = static_cast<float>(key_math::Center(v.y, width_)) - origin_.y();
    const auto z = static_cast<float>(key_math::Center(v.z, width_)) - origin_.z();
    const double squared =
        static_cast<double>(x * x) + static_cast<double>(y * y) + static_cast<double>(z * z);
    return squared > max_range_ * max_range_;
  }

  const VoxelGrid& grid_;
  Vector3f origin_;
  double width_;
  double max_range_;
  bool ignore_unknown_;
  bool origin_ok_ = false;
  VoxelIndex start_;
};

RayHit VoxelGrid::CastRay(const Vector3d& origin_W, const Vector3d& direction_W, double max_range_m,
                          bool ignore_unknown) const {
  return RayCaster(*this, origin_W.cast<float>(), max_range_m, ignore_unknown)
      .Cast(direction_W.cast<float>());
}

void VoxelGrid::CastRays(const Vector3f& origin_W, const Vector3f* directions_W, int count,
                         double max_range_m, bool ignore_unknown, RayHit* hits) const {
  const RayCaster caster(*this, origin_W, max_range_m, ignore_unknown);
  for (int i = 0; i < count; ++i) {
    hits[i] = caster.Cast(directions_W[i]);
  }
}

}  // namespace pipewright
