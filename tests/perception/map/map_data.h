// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "tests/perception/map/octomap_oracle.h"

/// The binary sets of $PIPEWRIGHT_SHARED/data/map: clouds (MPC1), views (MPV1), reference (MPM1).
namespace pipewright::test {

/// Empty when the variable is not set.
inline std::string SharedMapFolder() {
  const char* shared = std::getenv("PIPEWRIGHT_SHARED");
  return shared == nullptr ? "" : std::string(shared) + "/data/map/";
}

template <typename T>
T Get(std::istream& in) {
  T value{};
  in.read(reinterpret_cast<char*>(&value), sizeof(value));
  return value;
}

inline Vector3f GetVector(std::istream& in) {
  const auto x = Get<float>(in);
  const auto y = Get<float>(in);
  const auto z = Get<float>(in);
  return {x, y, z};
}

inline std::vector<Scan> ReadClouds(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::vector<Scan> scans;
  if (Get<std::uint32_t>(in) != 0x3143504D) {  // "MPC1"
    return scans;
  }
  const auto n = Get<std::uint32_t>(in);
  in.ignore(8 + 4);  // image size, resolution
  const auto max_range_m = Get<float>(in);
  in.ignore(8);  // fx, fy
  for (std::uint32_t i = 0; i < n; ++i) {
    Scan scan;
    scan.max_range_m = max_range_m;
    scan.origin_W = GetVector(in);
    in.ignore(36);  // rotation: the points are in W already
    scan.points_W.resize(Get<std::uint32_t>(in));
    for (Vector3f& p : scan.points_W) {
      p = GetVector(in);
    }
    scans.push_back(scan);
  }
  return scans;
}

/// A viewpoint of the planner's workload, with its rays.
struct View {
  Vector3f p_W;
  std::vector<Vector3f> visual_W;
  std::vector<Vector3f> coverage_W;
};

inline std::vector<View> ReadViews(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::vector<View> views;
  if (Get<std::uint32_t>(in) != 0x3156504D) {  // "MPV1"
    return views;
  }
  views.resize(Get<std::uint32_t>(in));
  const auto visual = Get<std::uint32_t>(in);
  const auto coverage = Get<std::uint32_t>(in);
  in.ignore(8);  // ranges: 3.0 and 0.4
  for (View& view : views) {
    view.p_W = GetVector(in);
    in.ignore(12);  // axis
    view.visual_W.resize(visual);
    view.coverage_W.resize(coverage);
    for (auto* rays : {&view.visual_W, &view.coverage_W}) {
      for (Vector3f& d : *rays) {
        d = GetVector(in);
      }
    }
  }
  return views;
}

/// 1 unless the workload calls the voxel covered.
inline std::uint32_t UncoveredInWorkload(const VoxelIndex& v) {
  const auto key = [](int i) { return static_cast<std::uint32_t>(i + 32768); };
  const std::uint32_t hash =
      (key(v.x) * 73856093U) ^ (key(v.y) * 19349663U) ^ (key(v.z) * 83492791U);
  return (hash & 3U) == 0 ? 0 : 1;
}

/// The box of that folder's workloads.
inline MapConfig WorkloadBox(const std::string& scene) {
  MapConfig config;
  const bool cube = scene == "cube";
  config.lo = config.workspace_lo = cube ? VoxelIndex{-2, -2, -2} : VoxelIndex{-8, -8, -8};
  config.hi = config.workspace_hi = cube ? VoxelIndex{32, 32, 32} : VoxelIndex{608, 408, 68};
  config.brick_capacity = BricksOfBox(config);
  return config;
}

}  // namespace pipewright::test
