// SPDX-License-Identifier: MIT
#include <algorithm>

#include "perception/map/fan_origin.h"
#include "perception/map/ray_walk.h"

namespace pipewright {
namespace {

SegmentTrace Walked(const VoxelGrid& grid, const Vector3f& origin_W, const Vector3f& end_W) {
  SegmentTrace trace;
  RayWalk ray(grid, origin_W, end_W);
  while (ray.Next() && ray.inside()) {
    if (grid.OccupiedAt(ray.index())) {
      trace.hit = true;
      trace.end = ray.voxel();
      break;
    }
    trace.unknown += grid.KnownAt(ray.index()) ? 0 : 1;
  }
  return trace;
}

}  // namespace

void VoxelGrid::TraceSegments(const Vector3f& origin_W, const Vector3f* ends_W, int count,
                              SegmentTrace* traces) const {
  fan::Origin origin;
  if (!AimFrom(config_, origin_W, HalfWidth::kFloat, &origin)) {
    std::fill(traces, traces + count, SegmentTrace{});
    return;
  }
  constexpr int kChunk = 256;
  fan::End ends[kChunk];
  int redo[kChunk + 1];
  for (int from = 0; from < count; from += kChunk) {
    const int n = std::min(kChunk, count - from);
    const int unsure = fan::Trace(origin, ends_W[from].data(), n, codes_.data(), ends, redo);
    for (int i = 0; i < n; ++i) {
      const fan::End& end = ends[i];
      SegmentTrace& trace = traces[from + i];
      trace = {.unknown = end.unknown, .hit = end.surface, .end = {}};
      if (end.surface) {
        trace.end = {origin.voxel[0] + end.off[0], origin.voxel[1] + end.off[1],
                     origin.voxel[2] + end.off[2]};
      }
    }
    for (int i = 0; i < unsure; ++i) {
      traces[from + redo[i]] = Walked(*this, origin_W, ends_W[from + redo[i]]);
    }
  }
}

}  // namespace pipewright
