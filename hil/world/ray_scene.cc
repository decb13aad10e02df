// SPDX-License-Identifier: MIT
#include "hil/world/ray_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cassert>

namespace pipewright::hil {
namespace {

constexpr double kPlaneHalfSide_m = 50;

void AttachTriangles(RTCDevice device, RTCScene scene, const std::vector<Vector3d>& vertices,
                     const std::vector<Mesh::Triangle>& triangles) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* v = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertices.size()));
  auto* t = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                                                           RTC_FORMAT_UINT3, 3 * sizeof(unsigned),
                                                           triangles.size()));
  for (const Vector3d& p : vertices) {
    v = std::copy_n(p.cast<float>().eval().data(), 3, v);
  }
  for (const Mesh::Triangle& triangle : triangles) {
    t = std::copy_n(triangle.begin(), 3, t);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

void AttachBox(RTCDevice device, RTCScene scene, const Vector3d& size_m, const Isometry3d& X_WG) {
  std::vector<Vector3d> corners;
  for (int i = 0; i < 8; ++i) {
    const Vector3d sign((i & 1) != 0 ? 0.5 : -0.5, (i & 2) != 0 ? 0.5 : -0.5,
                        (i & 4) != 0 ? 0.5 : -0.5);
    corners.push_back(X_WG * size_m.cwiseProduct(sign));
  }
  AttachTriangles(device, scene, corners,
                  {{0, 2, 3},
                   {0, 3, 1},
                   {4, 5, 7},
                   {4, 7, 6},
                   {0, 1, 5},
                   {0, 5, 4},
                   {2, 6, 7},
                   {2, 7, 3},
                   {0, 4, 6},
                   {0, 6, 2},
                   {1, 3, 7},
                   {1, 7, 5}});
}

/// Points with radii: one makes a sphere, two a capped cylinder.
void AttachRound(RTCDevice device, RTCScene scene, RTCGeometryType type,
                 const std::vector<Eigen::Vector4f>& points) {
  RTCGeometry geometry = rtcNewGeometry(device, type);
  auto* v = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), points.size()));
  for (const Eigen::Vector4f& p : points) {
    v = std::copy_n(p.data(), 4, v);
  }
  if (points.size() == 2) {
    auto* index = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, sizeof(unsigned), 1));
    *index = 0;
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

Eigen::Vector4f WithRadius(const Vector3d& p, double radius_m) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()),
          static_cast<float>(radius_m)};
}

void AttachPlane(RTCDevice device, RTCScene scene, const Isometry3d& X_WG) {
  const auto corner = [&](double x, double y) {
    return Vector3d(X_WG * Vector3d(x * kPlaneHalfSide_m, y * kPlaneHalfSide_m, 0));
  };
  AttachTriangles(device, scene, {corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)},
                  {{0, 1, 2}, {0, 2, 3}});
}

}  // namespace

void RayDeviceRelease::operator()(RTCDeviceTy* device) const { rtcReleaseDevice(device); }
void RaySceneRelease::operator()(RTCSceneTy* scene) const { rtcReleaseScene(scene); }

RayDevice NewRayDevice() {
  RayDevice device(rtcNewDevice("threads=1,set_affinity=0"));
  assert(device != nullptr);
  return device;
}

RayScenePtr NewRayScene(RTCDeviceTy* device) { return RayScenePtr(rtcNewScene(device)); }

void AttachShape(RTCDeviceTy* device, RTCSceneTy* scene, const Shape& shape,
                 const Isometry3d& X_WG) {
  switch (shape.kind) {
    case ShapeKind::kBox:
      return AttachBox(device, scene, shape.size_m, X_WG);
    case ShapeKind::kCylinder: {
      const Vector3d half(0, 0, shape.size_m.y() / 2);
      return AttachRound(
          device, scene, RTC_GEOMETRY_TYPE_CONE_LINEAR_CURVE,
          {WithRadius(X_WG * -half, shape.size_m.x()), WithRadius(X_WG * half, shape.size_m.x())});
    }
    case ShapeKind::kSphere:
      return AttachRound(device, scene, RTC_GEOMETRY_TYPE_SPHERE_POINT,
                         {WithRadius(X_WG.translation(), shape.size_m.x())});
    case ShapeKind::kTriangle:
      return AttachTriangles(
          device, scene,
          {X_WG * shape.corners_G[0], X_WG * shape.corners_G[1], X_WG * shape.corners_G[2]},
          {{0, 1, 2}});
  }
}

void AttachSolid(RTCDeviceTy* device, RTCSceneTy* scene, const Solid& solid) {
  switch (solid.kind) {
    case SolidKind::kPlane:
      return AttachPlane(device, scene, solid.X_WG);
    case SolidKind::kBox:
    case SolidKind::kCylinder:
      return AttachShape(device, scene, solid.shape, solid.X_WG);
    case SolidKind::kMesh:
      return AttachTriangles(device, scene, solid.mesh->vertices(), solid.mesh->triangles());
  }
}

RayScene::RayScene(const std::vector<Solid>& solids)
    : device_(NewRayDevice()), scene_(NewRayScene(device_.get())) {
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);  // no ray slips through an edge
  for (const Solid& solid : solids) {
    AttachSolid(device_.get(), scene_.get(), solid);
  }
  rtcCommitScene(scene_.get());
}

bool RayScene::Occluded(const Vector3d& from_W, const Vector3d& to_W, double gap_m) const {
  const Vector3d way = to_W - from_W;
  const double length = way.norm();
  if (length <= gap_m) {
    return false;
  }
  const Eigen::Vector3f origin = from_W.cast<float>();
  const Eigen::Vector3f direction = (way / length).cast<float>();
  RTCRay ray{};
  ray.org_x = origin.x();
  ray.org_y = origin.y();
  ray.org_z = origin.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.tfar = static_cast<float>(length - gap_m);
  ray.mask = ~0U;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene_.get(), &context, &ray);
  return ray.tfar < 0;
}

}  // namespace pipewright::hil
