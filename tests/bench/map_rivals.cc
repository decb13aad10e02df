// SPDX-License-Identifier: MIT
#include "tests/bench/map_rivals.h"

namespace pipewright::bench {
namespace {

constexpr double kCastRange_m = 5;
constexpr float kVisualRange_m = 3;
constexpr float kCoverageRange_m = 0.4F;

}  // namespace

OurMap::OurMap(const MapScene& scene) : scene_(scene), grid_(scene.config) {
  const std::size_t rays = scene.views.front().visual_W.size();
  hits_.resize(rays);
  ends_W_.resize(rays);
  traces_.resize(rays);
}

void OurMap::Insert(std::size_t scan, bool discretize) {
  test::InsertOurs(&grid_, scene_.scans[scan], discretize);
}

Checksum OurMap::Known() const { return {grid_.counts().free, grid_.counts().occupied}; }

Checksum OurMap::CastRays(std::size_t number) {
  Checksum sum{};
  const auto n = static_cast<int>(hits_.size());
  const test::View& view = scene_.views[number];
  grid_.CastRays(view.p_W, view.visual_W.data(), n, kCastRange_m, true, hits_.data());
  for (const RayHit& ray : hits_) {
    sum[0] += ray.hit ? 1 : 0;
    sum[1] += ray.end.x;
    sum[2] += ray.end.y;
    sum[3] += ray.end.z;
  }
  return sum;
}

Checksum OurMap::Evaluate(std::size_t number) {
  Checksum sum{};
  const auto n = static_cast<int>(ends_W_.size());
  const test::View& view = scene_.views[number];
  for (int i = 0; i < n; ++i) {
    ends_W_[i] = view.p_W + view.visual_W[i] * kVisualRange_m;
  }
  grid_.TraceSegments(view.p_W, ends_W_.data(), n, traces_.data());
  for (const SegmentTrace& trace : traces_) {
    sum[0] += trace.unknown;
    sum[1] += trace.hit ? 1 : 0;
  }
  for (int i = 0; i < n; ++i) {
    ends_W_[i] = view.p_W + view.coverage_W[i] * kCoverageRange_m;
  }
  grid_.TraceSegments(view.p_W, ends_W_.data(), n, traces_.data());
  for (const SegmentTrace& trace : traces_) {
    sum[2] += trace.hit ? test::UncoveredInWorkload(trace.end) : 0;
    sum[3] += trace.hit ? 1 : 0;
  }
  return sum;
}

OctomapMap::OctomapMap(const MapScene& scene) : scene_(scene) {
  for (const test::Scan& scan : scene.scans) {
    clouds_.emplace_back();
    for (const Vector3f& p : scan.points_W) {
      clouds_.back().push_back(test::ToOctomap(p));
    }
  }
}

void OctomapMap::Insert(std::size_t scan, bool discretize) {
  const test::Scan& s = scene_.scans[scan];
  tree_.insertPointCloud(clouds_[scan], test::ToOctomap(s.origin_W), s.max_range_m, false,
                         discretize);
}

Checksum OctomapMap::Known() const {
  Checksum sum{};
  const MapConfig& box = scene_.config;
  for (int z = box.lo.z; z <= box.hi.z; ++z) {
    for (int y = box.lo.y; y <= box.hi.y; ++y) {
      for (int x = box.lo.x; x <= box.hi.x; ++x) {
        const octomap::OcTreeNode* node = tree_.search(test::KeyOf({x, y, z}));
        if (node != nullptr) {
          ++sum[tree_.isNodeOccupied(node) ? 1 : 0];
        }
      }
    }
  }
  return sum;
}

Checksum OctomapMap::CastRays(std::size_t number) {
  Checksum sum{};
  const test::View& view = scene_.views[number];
  for (const Vector3f& d : view.visual_W) {
    octomap::point3d end;
    const bool hit =
        tree_.castRay(test::ToOctomap(view.p_W), test::ToOctomap(d), end, true, kCastRange_m);
    const octomap::OcTreeKey key = tree_.coordToKey(end);
    sum[0] += hit ? 1 : 0;
    for (int i = 0; i < 3; ++i) {
      sum[1 + i] += key[i] - 32768;
    }
  }
  return sum;
}

Checksum OctomapMap::Evaluate(std::size_t number) {
  Checksum sum{};
  const octomap::OcTreeKey lo = test::KeyOf(scene_.config.lo);
  const octomap::OcTreeKey hi = test::KeyOf(scene_.config.hi);
  const test::View& view = scene_.views[number];
  for (const bool visual : {true, false}) {
    const float range_m = visual ? kVisualRange_m : kCoverageRange_m;
    for (const Vector3f& d : visual ? view.visual_W : view.coverage_W) {
      tree_.computeRayKeys(test::ToOctomap(view.p_W), test::ToOctomap(view.p_W + d * range_m),
                           keys_);
      for (const octomap::OcTreeKey& key : keys_) {
        if (key[0] < lo[0] || key[1] < lo[1] || key[2] < lo[2] || key[0] > hi[0] ||
            key[1] > hi[1] || key[2] > hi[2]) {
          break;
        }
        const octomap::OcTreeNode* node = tree_.search(key);
        if (node != nullptr && tree_.isNodeOccupied(node)) {
          ++sum[visual ? 1 : 3];
          sum[2] +=
              visual ? 0
                     : test::UncoveredInWorkload({key[0] - 32768, key[1] - 32768, key[2] - 32768});
          break;
        }
        sum[0] += visual && node == nullptr ? 1 : 0;
      }
    }
  }
  return sum;
}

}  // namespace pipewright::bench
