// SPDX-License-Identifier: MIT
#include "perception/map/ray_walk.h"

namespace pipewright {

void VoxelGrid::TraceSegments(const Vector3f& origin_W, const Vector3f* ends_W, int count,
                              SegmentTrace* traces) const {
  for (int i = 0; i < count; ++i) {
    SegmentTrace trace;
    RayWalk ray(*this, origin_W, ends_W[i]);
    while (ray.Next() && ray.inside()) {
      if (OccupiedAt(ray.index())) {
        trace.hit = true;
        trace.end = ray.voxel();
        break;
      }
      trace.unknown += KnownAt(ray.index()) ? 0 : 1;
    }
    traces[i] = trace;
  }
}

}  // namespace pipewright
