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

RayGeometry::RayGeometry(RTCDeviceTy* device) : device_(device), scene_(rtcNewScene(device)) {}

void RayGeometry::Add(const Shape& shape, const Isometry3d& X_WG) {
  switch (shape.kind) {
    case ShapeKind::kBox:
      return AttachBox(device_, scene(), shape.size_m, X_WG);
    case ShapeKind::kCylinder:
    case ShapeKind::kSphere: {
      rounds_.push_back({shape, X_WG});
      RTCGeometry geometry = NewRoundGeometry(device_, &rounds_.back());
      rtcAttachGeometry(scene(), geometry);
      rtcReleaseGeometry(geometry);
      return;
    }
    case ShapeKind::kTriangle:
      return AttachTriangles(
          device_, scene(),
          {X_WG * shape.corners_G[0], X_WG * shape.corners_G[1], X_WG * shape.corners_G[2]},
          {{0, 1, 2}});
  }
}

void RayGeometry::Add(const Solid& solid) {
  switch (solid.kind) {
    case SolidKind::kPlane:
      return AttachPlane(device_, scene(), solid.X_WG);
    case SolidKind::kBox:
    case SolidKind::kCylinder:
      return Add(solid.shape, solid.X_WG);
    case SolidKind::kMesh:
      return AttachTriangles(device_, scene(), solid.mesh->vertices(), solid.mesh->triangles());
  }
}

RayScene::RayScene(const std::vector<Solid>& solids)
    : device_(NewRayDevice()), geometry_(device_.get()) {
  rtcSetSceneFlags(geometry_.scene(), RTC_SCENE_FLAG_ROBUST);  // no ray slips through an edge
  for (const Solid& solid : solids) {
    geometry_.Add(solid);
  }
  rtcCommitScene(geometry_.scene());
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
  rtcOccluded1(geometry_.scene(), &context, &ray);
  return ray.tfar < 0;
}

}  // namespace pipewright::hil
