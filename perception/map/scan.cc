// SPDX-License-Identifier: MIT
#include <algorithm>
#include <iterator>
#include <utility>

#include "perception/map/fan_origin.h"
#include "perception/map/ray_walk.h"

namespace pipewright {

/// One scan on its way into the grid: which voxels it hits and which it passes go to the window,
/// and from there, each once, row by row into the bricks. So a voxel changes once a scan and hits
/// win, without a set of either.
class ScanInserter {
 public:
  ScanInserter(VoxelGrid* grid, const Vector3f& origin_W, double max_range_m)
      : grid_(*grid),
        window_(grid->window_),
        origin_W_(origin_W),
        max_range_m_(max_range_m),
        width_inv_(1 / grid->config_.width_m) {
    origin_in_keys_ = key_math::VoxelOf(origin_W, width_inv_, &origin_voxel_);
    origin_in_box_ = AimFrom(grid->config_, origin_W, HalfWidth::kFloat, &origin_);
  }

  /// Points and their rays.
  ScanStats Insert(const Vector3f* points_W, int count) {
    stats_.points = count;
    OpenWindow(max_range_m_);
    for (int from = 0; from < count; from += kChunk) {
      Take(points_W + from, std::min(kChunk, count - from));
    }
    return Finish();
  }

  /// One ray for each voxel that holds points, to its centre. A voxel that is not in the box may
  /// have more than one: of those only the latest are remembered, and a ray's twin changes nothing.
  ScanStats InsertDiscretized(const Vector3f* points_W, int count) {
    stats_.points = count;
    OpenWindow(-1);  // points may lie farther off than their rays go
    const int ends = CollectEnds(points_W, count);
    window_.ClearHits();
    OpenWindow(max_range_m_);
    for (int i = 0; i < ends; ++i) {
      TakeCenterOf(points_W[grid_.ends_[i]]);
    }
    std::fill(std::begin(latest_), std::end(latest_),
              grid_.config_.lo);  // in the box: none of them
    for (int i = 0; outside_ > 0 && i < count; ++i) {
      VoxelIndex v;
      if (!key_math::VoxelOf(points_W[i], width_inv_, &v)) {
        ++stats_.rejected;
      } else if (!grid_.InBox(v) && !TakenLately(v)) {
        TakeCenterOf(points_W[i]);
      }
    }
    Take(centers_W_, centers_);
    return Finish();
  }

 private:
  static constexpr int kChunk = 256;
  static constexpr unsigned kLatest = 1024;

  /// All that rays of this range can reach in the box.
  void OpenWindow(double range_m) {
    VoxelIndex lo = grid_.config_.lo;
    VoxelIndex hi = grid_.config_.hi;
    constexpr double kCellsMax = 1 << 17;
    if (range_m >= 0 && origin_in_keys_) {
      // One voxel for the rest of a division, one for rounding.
      const int reach = static_cast<int>(std::min(range_m * width_inv_, kCellsMax)) + 2;
      const VoxelIndex& o = origin_voxel_;
      lo = {std::max(lo.x, o.x - reach), std::max(lo.y, o.y - reach), std::max(lo.z, o.z - reach)};
      hi = {std::min(hi.x, o.x + reach), std::min(hi.y, o.y + reach), std::min(hi.z, o.z + reach)};
    }
    window_.Open(lo, hi);
    if (origin_in_box_) {
      origin_.index = window_.IndexOf(origin_voxel_);
      origin_.stride[0] = 1;
      origin_.stride[1] = window_.stride_y();
      origin_.stride[2] = window_.stride_z();
    }
  }

  /// At most kChunk points.
  void Take(const Vector3f* points_W, int n) {
    if (!origin_in_box_) {
      for (int i = 0; i < n; ++i) {
        TakeSlowly(points_W[i]);
      }
      return;
    }
    fan::Clip(origin_, points_W->data(), n, max_range_m_, ends_W_->data(), hit_index_);
    window_.SetHits(hit_index_, n, [](int) {});
    const int none = fan::Mark(origin_, ends_W_->data(), n, window_.passed(), redo_);
    for (int i = 0; i < none; ++i) {
      Walk(ends_W_[redo_[i]]);
    }
  }

  /// From outside the box a ray may enter it anywhere.
  void TakeSlowly(const Vector3f& p_W) {
    const Vector3f along = p_W - origin_W_;
    const double distance = key_math::Norm(along);
    VoxelIndex v;
    if (max_range_m_ < 0 || distance <= max_range_m_) {
      if (key_math::VoxelOf(p_W, width_inv_, &v) && window_.Contains(v)) {
        window_.SetHit(window_.IndexOf(v));
      }
      Walk(p_W);
    } else {
      const Vector3f direction =
          distance > 0 ? key_math::Divided(along, static_cast<float>(distance)) : along;
      Walk(origin_W_ + direction * static_cast<float>(max_range_m_));
    }
  }

  /// The whole ray, one voxel at a time.
  void Walk(const Vector3f& end_W) {
    VoxelIndex v;
    if (!origin_in_keys_ || !key_math::VoxelOf(end_W, width_inv_, &v)) {
      ++stats_.rejected;
      return;
    }
    for (RayWalk ray(grid_, origin_W_, end_W); ray.Next();) {
      if (window_.Contains(ray.voxel())) {
        window_.SetPassed(window_.IndexOf(ray.voxel()));
      } else if (origin_in_box_ && !ray.inside()) {
        return;
      }
    }
  }

  /// Numbers of points, one for each voxel of the box that holds some.
  int CollectEnds(const Vector3f* points_W, int count) {
    const auto capacity = static_cast<int>(grid_.ends_.size());
    int ends = 0;
    int inside = 0;
    for (int from = 0; from < count; from += kChunk) {
      const int n = std::min(kChunk, count - from);
      FindCells(points_W + from, n);
      inside += window_.SetHits(hit_index_, n, [&](int i) {
        ends < capacity ? grid_.ends_[ends++] = from + i : ++stats_.rejected;
      });
    }
    outside_ = count - inside;
    return ends;
  }

  void FindCells(const Vector3f* points_W, int n) {
    if (origin_in_box_) {
      fan::Cells(origin_, points_W->data(), n, hit_index_);
      return;
    }
    for (int i = 0; i < n; ++i) {
      VoxelIndex v;
      const bool in_box = key_math::VoxelOf(points_W[i], width_inv_, &v) && grid_.InBox(v);
      hit_index_[i] = in_box ? window_.IndexOf(v) : -1;
    }
  }

  bool TakenLately(const VoxelIndex& v) {
    const unsigned slot = (static_cast<unsigned>(v.x) * 73856093U) ^
                          (static_cast<unsigned>(v.y) * 19349663U) ^
                          (static_cast<unsigned>(v.z) * 83492791U);
    VoxelIndex& latest = latest_[slot % kLatest];
    return std::exchange(latest, v) == v;
  }

  void TakeCenterOf(const Vector3f& p_W) {
    VoxelIndex v;
    key_math::VoxelOf(p_W, width_inv_, &v);
    centers_W_[centers_] = grid_.Center(v).cast<float>();
    if (++centers_ == kChunk) {
      Take(centers_W_, kChunk);
      centers_ = 0;
    }
  }

  ScanStats Finish() {
    window_.TakeRows([this](const VoxelIndex& row, std::uint32_t hits, std::uint32_t passed) {
      grid_.UpdateRow(row, hits, passed & ~hits, &stats_);
    });
    return stats_;
  }

  VoxelGrid& grid_;
  ScanWindow& window_;
  Vector3f origin_W_;
  double max_range_m_;
  double width_inv_;
  bool origin_in_keys_ = false;
  bool origin_in_box_ = false;
  VoxelIndex origin_voxel_;
  fan::Origin origin_{};
  Vector3f ends_W_[kChunk];
  std::int32_t hit_index_[kChunk];
  int redo_[kChunk + 1];
  Vector3f centers_W_[kChunk];  // of a discretised scan
  int centers_ = 0;
  int outside_ = 0;  // points, of a discretised scan
  VoxelIndex latest_[kLatest];
  ScanStats stats_;
};

ScanStats VoxelGrid::InsertScan(const Vector3f* points_W, int count, const Vector3f& origin_W,
                                double max_range_m) {
  return ScanInserter(this, origin_W, max_range_m).Insert(points_W, count);
}

ScanStats VoxelGrid::InsertScanDiscretized(const Vector3f* points_W, int count,
                                           const Vector3f& origin_W, double max_range_m) {
  return ScanInserter(this, origin_W, max_range_m).InsertDiscretized(points_W, count);
}

}  // namespace pipewright
