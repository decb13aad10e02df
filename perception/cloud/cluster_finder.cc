// SPDX-License-Identifier: MIT
#include "perception/cloud/cluster_finder.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>

namespace pipewright {
namespace {

/// Rounding may put points one reach apart two cubes apart, unless cubes are a bit wider.
constexpr float kWidthOverReach = 1.02F;

float Reach(const Eigen::Vector3f& p_SQ, const ClusterConfig& config) {
  return std::max(static_cast<float>(config.reach_m),
                  static_cast<float>(config.spacing_rad) * p_SQ.norm());
}

/// k: the reach is at least 2^k but less than 2^(k+1) times the least.
int Octave(float reach_m, const ClusterConfig& config) {
  return std::ilogb(reach_m / static_cast<float>(config.reach_m));
}

}  // namespace

Status ClusterFinder::Find(std::span<const Eigen::Vector3f> p_SQ, const ClusterConfig& config) {
  assert(Valid(config));
  clusters_.clear();
  clusters_refused_ = 0;
  if (const Status status = Take(p_SQ, config); status != Status::kOk) {
    return status;
  }
  for (int i = 0; i < points_; ++i) {
    parent_[i] = i;
  }
  for (int k = 0; k < kOctaves; ++k) {
    if (octave_[k] < octave_[k + 1]) {
      const float widest_m = std::ldexp(static_cast<float>(config.reach_m), k + 1);
      const float width_m = config.spacing_rad > 0 ? widest_m : widest_m / 2;
      Flood(octave_[k], octave_[std::min(k + 2, kOctaves)], kWidthOverReach * width_m);
    }
  }
  Rank(config.count_min);
  Measure(p_SQ);
  return points_refused_ > 0 || clusters_refused_ > 0 ? Status::kFull : Status::kOk;
}

/// Sorts the points there is room for by octaves.
Status ClusterFinder::Take(std::span<const Eigen::Vector3f> p_SQ, const ClusterConfig& config) {
  points_ = points_refused_ = 0;
  const auto far_m = static_cast<float>(kFar_reaches * config.reach_m);
  for (const Eigen::Vector3f& p : p_SQ) {
    // A comparison with NaN is false.
    if (!(p.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= far_m)) {
      return Status::kOutOfRange;
    }
  }
  points_ = std::min(static_cast<int>(p_SQ.size()), kMaxPoints);
  points_refused_ = static_cast<int>(p_SQ.size()) - points_;
  octave_.fill(0);
  for (int i = 0; i < points_; ++i) {
    ++octave_[Octave(Reach(p_SQ[i], config), config)];
  }
  int end = 0;
  for (int& octave : octave_) {
    end += octave;
    octave = end;
  }
  for (int i = points_ - 1; i >= 0; --i) {
    const float reach_m = Reach(p_SQ[i], config);
    const int k = --octave_[Octave(reach_m, config)];
    p_S_[k] = p_SQ[i];
    reach_m_[k] = reach_m;
    number_[k] = i;
  }
  return Status::kOk;
}

/// Unites what hangs together of the points begin ... end - 1, as octaves sort them.
void ClusterFinder::Flood(int begin, int end, float width_m) {
  const int count = end - begin;
  const Eigen::Vector3f* const p_S = &p_S_[begin];
  grid_.Set({p_S, static_cast<std::size_t>(count)}, width_m);
  std::fill_n(reached_.begin(), count, false);
  for (int seed = 0; seed < count; ++seed) {
    if (reached_[seed]) {
      continue;
    }
    int queued = 0;
    queue_[queued++] = seed;
    for (int next = 0; next < queued; ++next) {
      const int i = queue_[next];
      const float reach_m = reach_m_[begin + i];
      grid_.TakeNear(p_S[i], [&](int j) {
        const float least_m = std::min(reach_m, reach_m_[begin + j]);
        if ((p_S[j] - p_S[i]).squaredNorm() > least_m * least_m) {
          return false;
        }
        if (j != seed) {
          queue_[queued++] = j;
          Unite(number_[begin + seed], number_[begin + j]);
        }
        reached_[j] = true;
        return true;
      });
    }
  }
}

int ClusterFinder::Root(int point) {
  while (parent_[point] != point) {
    parent_[point] = parent_[parent_[point]];  // halves the way for those who come after
    point = parent_[point];
  }
  return point;
}

/// The lesser root stays one, so that a cluster's root is its first point.
void ClusterFinder::Unite(int a, int b) {
  const int root_a = Root(a);
  const int root_b = Root(b);
  parent_[std::max(root_a, root_b)] = std::min(root_a, root_b);
}

/// Labels the points of the largest clusters that there is room for.
void ClusterFinder::Rank(int count_min) {
  std::fill_n(count_.begin(), points_, 0);
  std::fill_n(label_.begin(), points_, kNone);
  for (int i = 0; i < points_; ++i) {
    ++count_[Root(i)];
  }
  int found = 0;
  for (int i = 0; i < points_; ++i) {
    if (count_[i] >= count_min && parent_[i] == i) {
      queue_[found++] = i;
    }
  }
  std::sort(queue_.begin(), queue_.begin() + found,
            [&](int a, int b) { return count_[a] != count_[b] ? count_[a] > count_[b] : a < b; });
  for (int k = 0; k < found; ++k) {
    PointCluster cluster;
    cluster.first = queue_[k];
    if (clusters_.push_back(cluster)) {
      label_[queue_[k]] = k;
    } else {
      ++clusters_refused_;
    }
  }
  for (int i = 0; i < points_; ++i) {
    label_[i] = label_[Root(i)];
  }
}

void ClusterFinder::Measure(std::span<const Eigen::Vector3f> p_SQ) {
  // About each cluster's first point: far from S's origin, moments about that would cancel.
  std::array<Vector3d, kMaxClusters> sum;
  std::array<Matrix3d, kMaxClusters> squares;
  sum.fill(Vector3d::Zero());
  squares.fill(Matrix3d::Zero());
  for (PointCluster& cluster : clusters_) {
    cluster.min_S = cluster.max_S = p_SQ[cluster.first].cast<double>();
  }
  for (int i = 0; i < points_; ++i) {
    if (label_[i] == kNone) {
      continue;
    }
    PointCluster& cluster = clusters_[label_[i]];
    const Vector3d p = p_SQ[i].cast<double>();
    const Vector3d w = p - p_SQ[cluster.first].cast<double>();
    ++cluster.points;
    sum[label_[i]] += w;
    squares[label_[i]] += w * w.transpose();
    cluster.min_S = cluster.min_S.cwiseMin(p);
    cluster.max_S = cluster.max_S.cwiseMax(p);
  }
  for (int k = 0; k < clusters_.size(); ++k) {
    PointCluster& cluster = clusters_[k];
    const Vector3d mean = sum[k] / cluster.points;
    cluster.centroid_S = p_SQ[cluster.first].cast<double>() + mean;
    const Matrix3d covariance = squares[k] / cluster.points - mean * mean.transpose();
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(covariance, Eigen::EigenvaluesOnly);
    cluster.spread_m = eigen.eigenvalues().reverse().cwiseMax(0).cwiseSqrt();
  }
}

}  // namespace pipewright
