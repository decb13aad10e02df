// SPDX-License-Identifier: MIT
#include "hil/world/round_geometry.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pipewright::hil {
namespace {

constexpr double kSlice_m = 0.25;

int Slices(const Shape& shape) {
  return shape.kind == ShapeKind::kCylinder
             ? std::max(1, static_cast<int>(std::ceil(shape.size_m.y() / kSlice_m)))
             : 1;
}

/// The bounds of a slice along the axis. The first begins at one cap and the last ends at the
/// other.
double SliceStart(const Shape& shape, int slice) {
  return shape.size_m.y() * (static_cast<double>(slice) / Slices(shape) - 0.5);
}

void Bounds(const RTCBoundsFunctionArguments* args) {
  const auto* round = static_cast<const RoundShape*>(args->geometryUserPtr);
  const int slice = static_cast<int>(args->primID);
  const double radius_m = round->shape.size_m.x();
  Vector3d center = round->X_WG.translation();
  Vector3d half = Vector3d::Constant(radius_m);
  if (round->shape.kind == ShapeKind::kCylinder) {
    const Vector3d axis = round->X_WG.linear().col(2);
    const double lo = SliceStart(round->shape, slice);
    const double hi = SliceStart(round->shape, slice + 1);
    center += axis * ((lo + hi) / 2);
    const Eigen::Array3d across = (1 - axis.array().square()).max(0).sqrt();
    half = axis.cwiseAbs() * ((hi - lo) / 2) + (radius_m * across).matrix();
  }
  // Single precision rounds: a micrometre and some more of slack.
  half.array() += 1e-6 + 1e-6 * center.array().abs();
  const Eigen::Vector3f lower = (center - half).cast<float>();
  const Eigen::Vector3f upper = (center + half).cast<float>();
  *args->bounds_o = {lower.x(), lower.y(), lower.z(), 0, upper.x(), upper.y(), upper.z(), 0};
}

struct Hit {
  double t = 0;
  Vector3d n_W = Vector3d::Zero();
};

bool Meets(const RoundShape& round, int slice, const RTCRayN* ray, unsigned n, unsigned i,
           Hit& hit) {
  // Embree's accessors take a pointer that is not const; they only read here.
  auto* r = const_cast<RTCRayN*>(ray);
  const Vector3d o_W(RTCRayN_org_x(r, n, i), RTCRayN_org_y(r, n, i), RTCRayN_org_z(r, n, i));
  const Vector3d d_W(RTCRayN_dir_x(r, n, i), RTCRayN_dir_y(r, n, i), RTCRayN_dir_z(r, n, i));
  const Matrix3d R_GW = round.X_WG.linear().transpose();
  Vector3d n_G;
  if (!IntersectRound(round.shape, R_GW * (o_W - round.X_WG.translation()), R_GW * d_W,
                      SliceStart(round.shape, slice), SliceStart(round.shape, slice + 1),
                      RTCRayN_tnear(r, n, i), RTCRayN_tfar(r, n, i), hit.t, n_G)) {
    return false;
  }
  hit.n_W = round.X_WG.linear() * n_G;
  return true;
}

void Intersect(const RTCIntersectFunctionNArguments* args) {
  const auto* round = static_cast<const RoundShape*>(args->geometryUserPtr);
  RTCRayN* ray = RTCRayHitN_RayN(args->rayhit, args->N);
  RTCHitN* record = RTCRayHitN_HitN(args->rayhit, args->N);
  for (unsigned i = 0; i < args->N; ++i) {
    Hit hit;
    if (args->valid[i] == 0 ||
        !Meets(*round, static_cast<int>(args->primID), ray, args->N, i, hit)) {
      continue;
    }
    RTCRayN_tfar(ray, args->N, i) = static_cast<float>(hit.t);
    RTCHitN_Ng_x(record, args->N, i) = static_cast<float>(hit.n_W.x());
    RTCHitN_Ng_y(record, args->N, i) = static_cast<float>(hit.n_W.y());
    RTCHitN_Ng_z(record, args->N, i) = static_cast<float>(hit.n_W.z());
    RTCHitN_geomID(record, args->N, i) = args->geomID;
    RTCHitN_primID(record, args->N, i) = args->primID;
    RTCHitN_instID(record, args->N, i, 0) = args->context->instID[0];
  }
}

void Occluded(const RTCOccludedFunctionNArguments* args) {
  const auto* round = static_cast<const RoundShape*>(args->geometryUserPtr);
  for (unsigned i = 0; i < args->N; ++i) {
    Hit hit;
    if (args->valid[i] != 0 &&
        Meets(*round, static_cast<int>(args->primID), args->ray, args->N, i, hit)) {
      RTCRayN_tfar(args->ray, args->N, i) = -std::numeric_limits<float>::infinity();
    }
  }
}

}  // namespace

bool IntersectRound(const Shape& shape, const Vector3d& o_G, const Vector3d& d_G, double slice_lo_m,
                    double slice_hi_m, double t_min, double t_max, double& t, Vector3d& n_G) {
  const bool ball = shape.kind == ShapeKind::kSphere;
  const double radius_m = shape.size_m.x();
  // |o + t d|^2 = r^2 about the centre, or about the axis.
  const Vector3d across(1, 1, ball ? 1 : 0);
  const Vector3d o = o_G.cwiseProduct(across);
  const Vector3d d = d_G.cwiseProduct(across);
  const double a = d.squaredNorm();
  const double b = o.dot(d);
  bool met = false;
  const auto offer = [&](double at, const Vector3d& normal) {
    if (at > t_min && at < t_max && (!met || at < t)) {
      met = true;
      t = at;
      n_G = normal;
    }
  };
  const double discriminant = b * b - a * (o.squaredNorm() - radius_m * radius_m);
  if (discriminant < 0) {
    return false;  // passes beside; a ray along the axis has a = b = 0 and goes on to the caps
  }
  if (a > 0) {
    for (const double root : {-std::sqrt(discriminant), std::sqrt(discriminant)}) {
      const double at = (root - b) / a;
      const double z = o_G.z() + at * d_G.z();
      if (ball || (z >= slice_lo_m && z <= slice_hi_m)) {
        offer(at, o + at * d);
      }
    }
  }
  const double half_m = shape.size_m.y() / 2;
  for (const double cap : {-half_m, half_m}) {
    const double at = (cap - o_G.z()) / d_G.z();
    const bool of_slice = cap >= slice_lo_m && cap <= slice_hi_m;
    if (!ball && of_slice && d_G.z() != 0 && (o + at * d).squaredNorm() <= radius_m * radius_m) {
      offer(at, Vector3d(0, 0, cap));
    }
  }
  return met;
}

RTCGeometryTy* NewRoundGeometry(RTCDeviceTy* device, const RoundShape* round) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(Slices(round->shape)));
  rtcSetGeometryUserData(geometry, const_cast<RoundShape*>(round));
  rtcSetGeometryBoundsFunction(geometry, Bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, Intersect);
  rtcSetGeometryOccludedFunction(geometry, Occluded);
  rtcCommitGeometry(geometry);
  return geometry;
}

}  // namespace pipewright::hil
