// SPDX-License-Identifier: MIT
#include <algorithm>
#include <limits>

#include "perception/map/ray_packet.h"
#include "perception/map/ray_walk.h"

namespace pipewright {

/// One scan on its way into the grid: hits first, each marked, then misses where no mark is. So a
/// voxel changes once a scan and hits win, without a set of either.
class ScanInserter {
 public:
  ScanInserter(VoxelGrid* grid, const Vector3f& origin_W, double max_range_m)
      : grid_(*grid),
        origin_(origin_W),
        max_range_(max_range_m),
        width_(grid->config_.width_m),
        width_inv_(1 / width_) {
    origin_in_keys_ = key_math::VoxelOf(origin_W, width_inv_, &origin_voxel_);
    origin_in_box_ = origin_in_keys_ && grid->InBox(origin_voxel_);
    std::fill(grid_.marks_.begin(), grid_.marks_.end(), 0);
    if (!origin_in_box_) {
      return;
    }
    const int at[3] = {origin_voxel_.x, origin_voxel_.y, origin_voxel_.z};
    const int lo[3] = {grid_.config_.lo.x, grid_.config_.lo.y, grid_.config_.lo.z};
    const int hi[3] = {grid_.config_.hi.x, grid_.config_.hi.y, grid_.config_.hi.z};
    const int strides[3] = {1, grid_.nx_, grid_.nx_ * grid_.ny_};
    origin_index_ = grid_.IndexOf(origin_voxel_);
    for (int i = 0; i < 3; ++i) {
      const double o = origin_[i];
      const auto half = static_cast<float>(width_ * 0.5);
      to_border_[1][i] = key_math::Center(at[i], width_) + half - o;
      to_border_[0][i] = key_math::Center(at[i], width_) + -half - o;
      to_wall_[1][i] = hi[i] - at[i];
      to_wall_[0][i] = at[i] - lo[i];
      stride_[1][i] = strides[i];
      stride_[0][i] = -strides[i];
    }
  }

  ScanStats& stats() { return stats_; }

  void Reject() { ++stats_.rejected; }

  /// A point's end of ray, hit or not, and whether it is a hit.
  bool EndOf(const Vector3f& p_W, Vector3f* end_W) const {
    *end_W = p_W;
    const Vector3f along = p_W - origin_;
    const double distance = key_math::Norm(along);
    if (max_range_ < 0 || distance <= max_range_) {
      return true;
    }
    const Vector3f direction =
        distance > 0 ? key_math::Divided(along, static_cast<float>(distance)) : along;
    *end_W = origin_ + direction * static_cast<float>(max_range_);
    return false;
  }

  void Hit(const Vector3f& p_W) {
    VoxelIndex v;
    Vector3f end;
    if (EndOf(p_W, &end) && key_math::VoxelOf(p_W, width_inv_, &v) && grid_.InBox(v)) {
      const int index = grid_.IndexOf(v);
      if (!Mark(index)) {
        ++(grid_.Update(index, v, true) ? stats_.hits : stats_.refused);
      }
    }
  }

  /// Queues the misses of one point's ray.
  void Ray(const Vector3f& p_W) {
    Vector3f end;
    VoxelIndex v;
    EndOf(p_W, &end);
    if (!origin_in_keys_ || !key_math::VoxelOf(end, width_inv_, &v)) {
      Reject();
      return;
    }
    if (v == origin_voxel_) {
      return;
    }
    if (!origin_in_box_) {
      Walk(end);
      return;
    }
    const Vector3f along = end - origin_;
    const auto length = static_cast<float>(key_math::Norm(along));
    if (!(length > 0)) {
      return;
    }
    Load(lanes_, v, key_math::Divided(along, length), length);
    ends_[lanes_] = end;
    if (++lanes_ == RayPacket::kLanes) {
      Flush();
    }
  }

  /// Walks what is queued.
  void Flush() {
    if (lanes_ == 0) {
      return;
    }
    for (int lane = lanes_; lane < RayPacket::kLanes; ++lane) {
      packet_.limit.Set(lane, RayPacket::kDone);
      packet_.index.Set(lane, 0);
      walk_too_[lane] = false;
    }
    Miss(origin_index_);
    RayPacket packet = packet_;  // a copy of its own can stay in registers
    const std::uint64_t* marks = grid_.marks_.data();
    while (packet.Step()) {
      for (int lane = 0; lane < RayPacket::kLanes; ++lane) {
        const int index = origin_index_ + static_cast<int>(packet.index[lane]);
        if (((marks[index >> 6] >> (index & 63)) & 1U) == 0) {
          MissNew(index);
        }
      }
    }
    for (int lane = 0; lane < lanes_; ++lane) {
      if (walk_too_[lane]) {
        Walk(ends_[lane]);
      }
    }
    lanes_ = 0;
  }

  bool Mark(int index) {
    std::uint64_t& word = grid_.marks_[index >> 6];
    const std::uint64_t bit = std::uint64_t{1} << (index & 63);
    const bool was = (word & bit) != 0;
    word |= bit;
    return was;
  }

 private:
  void Miss(int index) {
    if (((grid_.marks_[index >> 6] >> (index & 63)) & 1U) == 0) {
      MissNew(index);
    }
  }

  void MissNew(int index) {
    Mark(index);
    ++(grid_.Update(index, grid_.VoxelAt(index), false) ? stats_.misses : stats_.refused);
  }

  /// The whole ray, one voxel at a time, with every step checked against the box.
  void Walk(const Vector3f& end_W) {
    for (RayWalk ray(grid_, origin_, end_W); ray.Next();) {
      if (ray.inside()) {
        Miss(ray.index());
      } else if (origin_in_box_) {
        return;
      }
    }
  }

  void Load(int lane, const VoxelIndex& end, const Vector3f& direction, float length) {
    constexpr double kNever = std::numeric_limits<double>::max();
    for (int i = 0; i < 3; ++i) {
      const double d = direction[i];
      const int up = d > 0 ? 1 : 0;
      packet_.t_next[i].Set(lane, d != 0 ? to_border_[up][i] / d : kNever);
      packet_.t_delta[i].Set(lane, d != 0 ? width_ / std::abs(d) : kNever);
      packet_.stride[i].Set(lane, stride_[up][i]);
    }
    packet_.limit.Set(lane, length);
    packet_.end.Set(lane, static_cast<double>(grid_.FlatIndex(end) - origin_index_));
    packet_.index.Set(lane, 0);
    walk_too_[lane] = false;
    const VoxelIndex& lo = grid_.config_.lo;
    const VoxelIndex& hi = grid_.config_.hi;
    if (!Within(end, {lo.x + 1, lo.y + 1, lo.z + 1}, {hi.x - 1, hi.y - 1, hi.z - 1})) {
      StopAtWall(lane, direction, length);
    }
  }

  // Rounding can carry a ray one voxel past its end, and this ray may leave the box by that: the
  // packet goes as far as is sure. That is all of the ray if it passes the wall well before its end
  // and crosses nothing else just there; if not, Walk goes over it again, slowly.
  void StopAtWall(int lane, const Vector3f& direction, float length) {
    constexpr double kNowhere = 1e18;  // no flat index
    constexpr double kSure = 1e-6;     // metres; rounding is five orders below
    double wall = length;
    int axis = -1;
    for (int i = 0; i < 3; ++i) {
      const int up = direction[i] > 0 ? 1 : 0;
      const double t = packet_.t_next[i][lane] + to_wall_[up][i] * packet_.t_delta[i][lane];
      if (direction[i] != 0 && t < wall) {
        wall = t;
        axis = i;
      }
    }
    packet_.end.Set(lane, kNowhere);
    walk_too_[lane] = axis < 0 || wall > length - 2 * kSure;
    for (int i = 0; i < 3; ++i) {
      if (i != axis && direction[i] != 0) {
        const double delta = packet_.t_delta[i][lane];
        const double crossings = (wall - packet_.t_next[i][lane]) / delta;
        const double off = crossings - std::floor(crossings);
        walk_too_[lane] |= std::min(off, 1 - off) * delta < 2 * kSure;
      }
    }
    packet_.limit.Set(lane, walk_too_[lane] ? wall - kSure : wall + kSure);
  }

  VoxelGrid& grid_;
  Vector3f origin_;
  double max_range_;
  double width_;
  double width_inv_;
  bool origin_in_keys_ = false;
  bool origin_in_box_ = false;
  VoxelIndex origin_voxel_;
  int origin_index_ = 0;
  double to_border_[2][3] = {};  // of the origin's voxel, downwards and upwards
  double to_wall_[2][3] = {};    // voxels between the origin's and the end of the box
  double stride_[2][3] = {};
  RayPacket packet_{};
  Vector3f ends_[RayPacket::kLanes];
  bool walk_too_[RayPacket::kLanes] = {};
  int lanes_ = 0;
  ScanStats stats_;
};

ScanStats VoxelGrid::InsertScan(const Vector3f* points_W, int count, const Vector3f& origin_W,
                                double max_range_m) {
  ScanInserter scan(this, origin_W, max_range_m);
  scan.stats().points = count;
  for (int i = 0; i < count; ++i) {
    scan.Hit(points_W[i]);
  }
  for (int i = 0; i < count; ++i) {
    scan.Ray(points_W[i]);
  }
  scan.Flush();
  return scan.stats();
}

ScanStats VoxelGrid::InsertScanDiscretized(const Vector3f* points_W, int count,
                                           const Vector3f& origin_W, double max_range_m) {
  ScanInserter scan(this, origin_W, max_range_m);
  scan.stats().points = count;
  const double inv = 1 / config_.width_m;
  const auto center = [this](const VoxelIndex& v) { return Vector3f(Center(v).cast<float>()); };
  int ends = 0;
  VoxelIndex v;
  for (int i = 0; i < count; ++i) {
    if (key_math::VoxelOf(points_W[i], inv, &v) && InBox(v) && !scan.Mark(IndexOf(v))) {
      if (ends == static_cast<int>(ends_.size())) {
        scan.Reject();
        continue;
      }
      ends_[ends++] = IndexOf(v);
    }
  }
  std::fill(marks_.begin(), marks_.end(), 0);
  for (int i = 0; i < ends; ++i) {
    scan.Hit(center(VoxelAt(ends_[i])));
  }
  for (int i = 0; i < ends; ++i) {
    scan.Ray(center(VoxelAt(ends_[i])));
  }
  for (int i = 0; i < count; ++i) {
    if (!key_math::VoxelOf(points_W[i], inv, &v)) {
      scan.Reject();
    } else if (!InBox(v)) {
      scan.Ray(center(v));
    }
  }
  scan.Flush();
  return scan.stats();
}

}  // namespace pipewright
