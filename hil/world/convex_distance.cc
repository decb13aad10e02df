// SPDX-License-Identifier: MIT
#include "hil/world/convex_distance.h"

#include <algorithm>
#include <cmath>

namespace pipewright::hil {
namespace {

constexpr double kTolerance_m = 1e-8;
constexpr int kMaxIterations = 256;

/// Up to four points of the Minkowski difference A - B, in A's frame.
struct Simplex {
  Vector3d points[4] = {Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
  int size = 0;

  void Keep(const Vector3d& a) {
    points[0] = a;
    size = 1;
  }
  void Keep(const Vector3d& a, const Vector3d& b) {
    points[0] = a;
    points[1] = b;
    size = 2;
  }
  void Keep(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    points[0] = a;
    points[1] = b;
    points[2] = c;
    size = 3;
  }
};

/// Each Nearest...: the point of a simplex's hull that is nearest to the origin; keeps the vertices
/// of the feature it lies on. After Ericson, Real-Time Collision Detection, 2005, 5.1.
Vector3d NearestOnSegment(const Vector3d& a, const Vector3d& b, Simplex& keep) {
  const Vector3d ab = b - a;
  const double along = -a.dot(ab);
  const double length2 = ab.squaredNorm();
  if (along <= 0 || length2 == 0) {
    keep.Keep(a);
    return a;
  }
  if (along >= length2) {
    keep.Keep(b);
    return b;
  }
  keep.Keep(a, b);
  return a + ab * (along / length2);
}

/// The nearest point on the edges alone: for triangles too thin for their normal to mean anything.
Vector3d NearestOnEdges(const Vector3d& a, const Vector3d& b, const Vector3d& c, Simplex& keep) {
  const Vector3d corners[3] = {a, b, c};
  Vector3d best = Vector3d::Constant(1e300);
  for (int i = 0; i < 3; ++i) {
    Simplex edge;
    const Vector3d v = NearestOnSegment(corners[i], corners[(i + 1) % 3], edge);
    if (i == 0 || v.squaredNorm() < best.squaredNorm()) {
      best = v;
      keep = edge;
    }
  }
  return best;
}

Vector3d NearestOnTriangle(const Vector3d& a, const Vector3d& b, const Vector3d& c, Simplex& keep) {
  const Vector3d n = (b - a).cross(c - a);
  const double n2 = n.squaredNorm();
  const double longest2 =
      std::max({(b - a).squaredNorm(), (c - a).squaredNorm(), (c - b).squaredNorm()});
  if (n2 <= 1e-24 * longest2 * longest2) {
    return NearestOnEdges(a, b, c, keep);
  }
  // Inside the prism over the triangle when the origin is on the inner side of all three edges.
  const bool inside = n.dot((b - a).cross(-a)) >= 0 && n.dot((c - b).cross(-b)) >= 0 &&
                      n.dot((a - c).cross(-c)) >= 0;
  if (!inside) {
    return NearestOnEdges(a, b, c, keep);
  }
  keep.Keep(a, b, c);
  return n * (a.dot(n) / n2);
}

/// False: the origin lies inside.
bool NearestOnTetrahedron(const Simplex& s, Simplex& keep, Vector3d& nearest) {
  constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}};
  bool outside = false;
  for (const auto& f : kFaces) {
    const Vector3d& a = s.points[f[0]];
    const Vector3d n = (s.points[f[1]] - a).cross(s.points[f[2]] - a);
    const double inner = n.dot(s.points[f[3]] - a);
    const double origin = -n.dot(a);
    if (inner * origin > 0) {
      continue;  // same side as the fourth vertex
    }
    Simplex face;
    const Vector3d v = NearestOnTriangle(a, s.points[f[1]], s.points[f[2]], face);
    if (!outside || v.squaredNorm() < nearest.squaredNorm()) {
      nearest = v;
      keep = face;
    }
    outside = true;
  }
  return outside;
}

/// Reduces the simplex to the feature nearest to the origin. False: the origin lies inside.
bool Reduce(Simplex& s, Vector3d& nearest) {
  const Simplex from = s;
  switch (from.size) {
    case 1:
      nearest = from.points[0];
      return true;
    case 2:
      nearest = NearestOnSegment(from.points[0], from.points[1], s);
      return true;
    case 3:
      nearest = NearestOnTriangle(from.points[0], from.points[1], from.points[2], s);
      return true;
    default:
      return NearestOnTetrahedron(from, s, nearest);
  }
}

}  // namespace

double ConvexDistance(const Shape& a, const Isometry3d& X_WA, const Shape& b,
                      const Isometry3d& X_WB, double stop_above_m) {
  const Matrix3d R_AW = X_WA.linear().transpose();
  const Matrix3d R_AB = R_AW * X_WB.linear();
  const Vector3d p_AB = R_AW * (X_WB.translation() - X_WA.translation());
  const auto difference = [&](const Vector3d& d_A) -> Vector3d {
    return Support(a, d_A) - (p_AB + R_AB * Support(b, R_AB.transpose() * -d_A));
  };

  Vector3d v = p_AB.squaredNorm() > 0 ? Vector3d(-p_AB) : Vector3d::UnitX();
  v = difference(-v);
  Simplex simplex;
  simplex.Keep(v);
  double upper = v.norm();
  double lower = 0;
  for (int i = 0; i < kMaxIterations && upper > kTolerance_m; ++i) {
    const Vector3d w = difference(-v);
    lower = std::max(lower, v.dot(w) / v.norm());
    if (upper - lower <= kTolerance_m || lower > stop_above_m) {
      break;
    }
    simplex.points[simplex.size++] = w;
    if (!Reduce(simplex, v)) {
      return 0;
    }
    const double norm = v.norm();
    if (norm >= upper) {
      break;  // rounding: no further progress is possible
    }
    upper = norm;
  }
  if (lower > stop_above_m) {
    return lower;
  }
  return upper <= kTolerance_m ? 0 : upper;
}

}  // namespace pipewright::hil
