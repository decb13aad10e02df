// SPDX-License-Identifier: MIT
#include "plan/motion/narrow_phase.h"

#include <ccd/ccd.h>

#include <algorithm>
#include <cmath>

namespace pipewright {
namespace {

struct Posed {
  const BodyShape& shape;
  Isometry3d X_WG;
  double margin_m;
};

struct VoxelBoxShape {
  Vector3d p_WCenter;
  double half_m;
};

Vector3d Corner(const Vector3d& direction, const Vector3d& half_m) {
  return {std::copysign(half_m.x(), direction.x()), std::copysign(half_m.y(), direction.y()),
          std::copysign(half_m.z(), direction.z())};
}

void ShapeSupport(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* support) {
  const Posed& posed = *static_cast<const Posed*>(object);
  const Vector3d d_W(direction->v);
  const Vector3d d_G = posed.X_WG.linear().transpose() * d_W;
  Vector3d p_G = Corner(d_G, posed.shape.half_m);
  if (posed.shape.kind == BodyShape::Kind::kCylinder) {
    const double across = std::sqrt(d_G.x() * d_G.x() + d_G.y() * d_G.y());
    const double scale = across > 0 ? posed.shape.half_m.x() / across : 0;
    p_G.x() = scale * d_G.x();
    p_G.y() = scale * d_G.y();
  }
  const double norm = std::sqrt(d_W.squaredNorm());
  const Vector3d grown_W = norm > 0 ? Vector3d(posed.margin_m / norm * d_W) : Vector3d::Zero();
  Eigen::Map<Vector3d>(support->v) = posed.X_WG * p_G + grown_W;
}

void VoxelSupport(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* support) {
  const VoxelBoxShape& box = *static_cast<const VoxelBoxShape*>(object);
  Eigen::Map<Vector3d>(support->v) =
      box.p_WCenter + Corner(Vector3d(direction->v), Vector3d::Constant(box.half_m));
}

/// Distance from a point in G to the shape, 0 inside.
double PointDistance(const BodyShape& shape, const Vector3d& p_G) {
  Vector3d beyond = p_G.cwiseAbs() - shape.half_m;
  if (shape.kind == BodyShape::Kind::kCylinder) {
    beyond.x() = std::sqrt(p_G.x() * p_G.x() + p_G.y() * p_G.y()) - shape.half_m.x();
    beyond.y() = 0;
  }
  return std::sqrt(beyond.cwiseMax(0).squaredNorm());
}

bool Intersect(const Posed& posed, const VoxelBoxShape& voxel) {
  constexpr unsigned long kRounds = 100;
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ShapeSupport;
  ccd.support2 = VoxelSupport;
  ccd.max_iterations = kRounds;
  return ccdGJKIntersect(&posed, &voxel, &ccd) != 0;
}

}  // namespace

bool MeetsObstacle(const BodyShape& shape, const Isometry3d& X_WG, double margin_m,
                   const VoxelGrid& map) {
  const double half_m = map.config().width_m / 2;
  const double half_diagonal_m = std::sqrt(3.0) * half_m;
  const double reach_m = std::sqrt(shape.half_m.squaredNorm()) + margin_m;
  const Vector3d reach = Vector3d::Constant(reach_m);
  const Posed posed{shape, X_WG, margin_m};
  const Isometry3d X_GW = X_WG.inverse();
  const VoxelIndex lo = map.VoxelOf(X_WG.translation() - reach);
  const VoxelIndex hi = map.VoxelOf(X_WG.translation() + reach);
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        const VoxelIndex v{x, y, z};
        if (!(map.InBox(v) ? map.Obstacle(v) : map.config().outside_is_obstacle)) {
          continue;
        }
        const Vector3d p_WCenter = map.Center(v);
        const double to_center_m = PointDistance(shape, X_GW * p_WCenter);
        if (to_center_m > margin_m + half_diagonal_m) {
          continue;
        }
        if (to_center_m <= margin_m + half_m || Intersect(posed, {p_WCenter, half_m})) {
          return true;
        }
      }
    }
  }
  return false;
}

double SegmentDistance(const Vector3d& a0, const Vector3d& a1, const Vector3d& b0,
                       const Vector3d& b1) {
  constexpr double kPoint_m2 = 1e-18;
  const Vector3d da = a1 - a0;
  const Vector3d db = b1 - b0;
  const Vector3d r = a0 - b0;
  const double a = da.squaredNorm();
  const double e = db.squaredNorm();
  const double c = da.dot(r);
  const double f = db.dot(r);
  double s = 0;
  double t = 0;
  if (a <= kPoint_m2 && e <= kPoint_m2) {
    return std::sqrt(r.squaredNorm());
  }
  if (a <= kPoint_m2) {
    t = std::clamp(f / e, 0.0, 1.0);
  } else if (e <= kPoint_m2) {
    s = std::clamp(-c / a, 0.0, 1.0);
  } else {
    const double b = da.dot(db);
    const double denominator = a * e - b * b;
    s = denominator > 0 ? std::clamp((b * f - c * e) / denominator, 0.0, 1.0) : 0.0;
    t = (b * s + f) / e;
    if (t < 0) {
      t = 0;
      s = std::clamp(-c / a, 0.0, 1.0);
    } else if (t > 1) {
      t = 1;
      s = std::clamp((b - c) / a, 0.0, 1.0);
    }
  }
  return std::sqrt((a0 + s * da - b0 - t * db).squaredNorm());
}

double SegmentBoxDistance(const Vector3d& a0, const Vector3d& a1, const Vector3d& half_m) {
  const auto squared_at = [&](double t) {
    return ((a0 + t * (a1 - a0)).cwiseAbs() - half_m).cwiseMax(0).squaredNorm();
  };
  // Convex in t: thirds of the bracket are cut away until it is shorter than 1e-4 of the segment.
  constexpr int kCuts = 23;
  double lo = 0;
  double hi = 1;
  for (int i = 0; i < kCuts; ++i) {
    const double third = (hi - lo) / 3;
    if (squared_at(lo + third) <= squared_at(hi - third)) {
      hi -= third;
    } else {
      lo += third;
    }
  }
  return std::sqrt(squared_at((lo + hi) / 2));
}

}  // namespace pipewright
