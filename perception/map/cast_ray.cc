// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "perception/map/fan_origin.h"
#include "perception/map/voxel_grid.h"

namespace pipewright {

/// OctoMap's castRay: step by step for one ray; for many of one origin, side by side as far as is
/// sure, and the rest of the way one by one.
class RayCaster {
 public:
  RayCaster(const VoxelGrid& grid, const Vector3f& origin_W, double max_range_m,
            bool ignore_unknown)
      : grid_(grid),
        origin_W_(origin_W),
        width_m_(grid.config_.width_m),
        max_range_m_(max_range_m),
        // A voxel entered this early has its centre within the range: no need to compute it.
        sure_m_(max_range_m > 0 ? max_range_m - 2 * width_m_ : kNever),
        ignore_unknown_(ignore_unknown) {
    origin_ok_ = key_math::VoxelOf(origin_W, 1 / width_m_, &start_);
  }

  RayHit Cast(const Vector3f& direction_W) const {
    RayHit ray{.hit = false, .end = start_};
    const double norm = key_math::Norm(direction_W);
    if (!origin_ok_ || !(norm > 0) || norm > std::numeric_limits<float>::max() ||
        Stops(start_, &ray.hit)) {
      return ray;
    }
    Walk walk = From(key_math::Divided(direction_W, static_cast<float>(norm)));
    while (Next(&walk)) {
      const VoxelIndex v{walk.at[0], walk.at[1], walk.at[2]};
      if ((walk.entered_m > sure_m_ && BeyondRange(v)) || Stops(v, &ray.hit)) {
        break;
      }
    }
    ray.end = {walk.at[0], walk.at[1], walk.at[2]};
    return ray;
  }

  void CastMany(const Vector3f* directions_W, int count, RayHit* hits) const {
    fan::Origin origin;
    bool hit = false;
    if (!AimFrom(grid_.config_, origin_W_, HalfWidth::kDouble, &origin) || Stops(start_, &hit) ||
        sure_m_ <= 0) {
      for (int i = 0; i < count; ++i) {
        hits[i] = Cast(directions_W[i]);
      }
      return;
    }
    constexpr int kChunk = 256;
    fan::End ends[kChunk];
    int redo[kChunk + 1];
    for (int from = 0; from < count; from += kChunk) {
      const int n = std::min(kChunk, count - from);
      const int unsure = fan::Cast(origin, directions_W[from].data(), n, sure_m_, !ignore_unknown_,
                                   grid_.codes_.data(), ends, redo);
      redo[unsure] = -1;
      const int* again = redo;
      for (int i = 0; i < n; ++i) {
        std::optional<RayHit> ray;
        if (*again == i) {
          ++again;
        } else {
          ray = Finish(directions_W[from + i], ends[i]);
        }
        hits[from + i] = ray ? *ray : Cast(directions_W[from + i]);
      }
    }
  }

 private:
  static constexpr double kNever = std::numeric_limits<double>::max();

  /// A ray on its way, in the numbers of OctoMap.
  struct Walk {
    int at[3];
    int step[3];
    double t_next_m[3];
    double t_delta_m[3];
    double entered_m;  ///< where the ray came into the voxel
  };

  Walk From(const Vector3f& direction) const {
    Walk walk{.at = {start_.x, start_.y, start_.z},
              .step = {},
              .t_next_m = {},
              .t_delta_m = {},
              .entered_m = 0};
    for (int i = 0; i < 3; ++i) {
      const double d = direction[i];
      walk.step[i] = d > 0 ? 1 : d < 0 ? -1 : 0;
      const double border = key_math::Center(walk.at[i], width_m_) + walk.step[i] * width_m_ * 0.5;
      walk.t_next_m[i] = d != 0 ? (border - static_cast<double>(origin_W_[i])) / d : kNever;
      walk.t_delta_m[i] = d != 0 ? width_m_ / std::abs(d) : kNever;
    }
    return walk;
  }

  static int NextAxis(const Walk& walk) {
    const int axis = walk.t_next_m[0] < walk.t_next_m[1] ? 0 : 1;
    return walk.t_next_m[axis] < walk.t_next_m[2] ? axis : 2;
  }

  /// Into the next voxel. False: the keys end here.
  static bool Next(Walk* walk) {
    const int axis = NextAxis(*walk);
    if (walk->at[axis] == (walk->step[axis] > 0 ? key_math::kReach - 1 : -key_math::kReach)) {
      return false;
    }
    walk->entered_m = walk->t_next_m[axis];
    walk->at[axis] += walk->step[axis];
    walk->t_next_m[axis] += walk->t_delta_m[axis];
    return true;
  }

  /// Puts a fresh walk to where it has made these crossings. Not to the last bit: see Apart.
  static void Skip(const std::array<int, 3>& crossings, Walk* walk) {
    for (int i = 0; i < 3; ++i) {
      if (crossings[i] > 0) {
        walk->at[i] += crossings[i] * walk->step[i];
        walk->t_next_m[i] += crossings[i] * walk->t_delta_m[i];
      }
    }
  }

  /// Whether the next crossing is the next one by so much that a skip's rounding cannot matter.
  static bool Apart(const Walk& walk) {
    constexpr double kSure_m = 1e-9;
    const int axis = NextAxis(walk);
    const double t = walk.t_next_m[axis] + kSure_m;
    return t < walk.t_next_m[(axis + 1) % 3] && t < walk.t_next_m[(axis + 2) % 3];
  }

  /// The rest of a ray of which all is known up to `end`. Nothing: it must be cast from its start.
  std::optional<RayHit> Finish(const Vector3f& direction_W, const fan::End& end) const {
    RayHit ray{.hit = end.surface,
               .end = {start_.x + end.off[0], start_.y + end.off[1], start_.z + end.off[2]}};
    if (end.by_sight) {
      return ray;
    }
    const Vector3f direction =
        key_math::Divided(direction_W, static_cast<float>(key_math::Norm(direction_W)));
    Walk walk = From(direction);
    Skip({std::abs(end.off[0]), std::abs(end.off[1]), std::abs(end.off[2])}, &walk);
    for (bool skipped = false;;) {
      if (!Apart(walk) || !Next(&walk)) {
        return std::nullopt;
      }
      ray.end = {walk.at[0], walk.at[1], walk.at[2]};
      if (BeyondRange(ray.end) || Stops(ray.end, &ray.hit)) {
        return ray;
      }
      if (!skipped && !grid_.InBox(ray.end)) {  // nothing can end it now before its range does
        if (max_range_m_ <= 0) {
          return std::nullopt;
        }
        skipped = true;
        walk = From(direction);
        Skip(CrossingsUpTo(sure_m_, walk), &walk);
      }
    }
  }

  /// Outside the box all is unknown.
  bool Stops(const VoxelIndex& v, bool* hit) const {
    const unsigned code = grid_.InBox(v) ? grid_.Code(grid_.IndexOf(v)) : 0;
    *hit = code == VoxelGrid::kOccupiedCode;
    return *hit || (!ignore_unknown_ && (code & VoxelGrid::kKnown) == 0);
  }

  static std::array<int, 3> CrossingsUpTo(double length_m, const Walk& walk) {
    std::array<int, 3> crossings{};
    for (int i = 0; i < 3; ++i) {
      const double after_first_m = length_m - walk.t_next_m[i];
      crossings[i] =
          after_first_m >= 0 ? static_cast<int>(after_first_m / walk.t_delta_m[i]) + 1 : 0;
    }
    return crossings;
  }

  bool BeyondRange(const VoxelIndex& v) const {
    const auto x = static_cast<float>(key_math::Center(v.x, width_m_)) - origin_W_.x();
    const auto y = static_cast<float>(key_math::Center(v.y, width_m_)) - origin_W_.y();
    const auto z = static_cast<float>(key_math::Center(v.z, width_m_)) - origin_W_.z();
    const double squared =
        static_cast<double>(x * x) + static_cast<double>(y * y) + static_cast<double>(z * z);
    return max_range_m_ > 0 && squared > max_range_m_ * max_range_m_;
  }

  const VoxelGrid& grid_;
  Vector3f origin_W_;
  double width_m_;
  double max_range_m_;
  double sure_m_;
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
  RayCaster(*this, origin_W, max_range_m, ignore_unknown).CastMany(directions_W, count, hits);
}

}  // namespace pipewright
