// SPDX-License-Identifier: MIT
#include "hil/sensors/depth_camera.h"

#include <embree3/rtcore.h>

#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace pipewright::hil {
namespace {

constexpr int kPacket = 16;

constexpr float kGrazingNone = 0.2F;  ///< cosine above which no reading is lost to grazing
constexpr float kGrazingAll = 0.05F;  ///< below which all are
constexpr float kJump_m = 0.05F;
constexpr float kJumpPerMetre = 0.05F;
constexpr std::uint32_t kJumpLost = 1U << 15;  ///< of 2^16
constexpr double kDisparities = 126;           ///< the matcher's search range [px]
constexpr double kWrongShare = 0.4;            ///< relative error of a reading that is merely off

/// splitmix64's finaliser: 64 well mixed bits of a counter.
constexpr std::uint64_t Mix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15U;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9U;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBU;
  return x ^ (x >> 31);
}

constexpr double Unit(std::uint64_t bits16) { return static_cast<double>(bits16 & 0xFFFF) / 65536; }

/// The standard normal's quantiles at (i + 1/2) / 4096: a normal number for 12 random bits, up to
/// 3.7 sigma. Newton's iteration on the distribution function.
std::array<float, 4096> NormalQuantiles() {
  std::array<float, 4096> table{};
  double z = -3.8;
  for (int i = 0; i < 4096; ++i) {
    const double p = (i + 0.5) / 4096;
    for (int k = 0; k < 50; ++k) {
      const double error = std::erfc(-z / std::numbers::sqrt2) / 2 - p;
      z -= error * std::sqrt(2 * std::numbers::pi) * std::exp(z * z / 2);
    }
    table[i] = static_cast<float>(z);
  }
  return table;
}

double Normal(std::uint64_t bits12) {
  static const std::array<float, 4096> kQuantiles = NormalQuantiles();
  return kQuantiles[bits12 & 4095];
}

void SetTransform(RTCGeometry instance, const Isometry3d& X_WG) {
  const Eigen::Matrix<float, 3, 4> m = X_WG.matrix().topRows<3>().cast<float>();
  rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, m.data());
}

CameraIntrinsics IntrinsicsOf(const CameraSpec& spec) {
  CameraIntrinsics c;
  c.width = spec.width;
  c.height = spec.height;
  c.fx = spec.width / (2 * std::tan(spec.hfov_deg * std::numbers::pi / 360));
  c.fy = c.fx;
  c.cx = (spec.width - 1) / 2.0;
  c.cy = (spec.height - 1) / 2.0;
  c.z_min_m = spec.z_min_m;
  c.z_max_m = spec.z_max_m;
  return c;
}

}  // namespace

DepthCamera::DepthCamera(const CameraSpec& spec, const std::vector<Solid>& solids,
                         const RobotBodies& robot, std::uint64_t seed)
    : spec_(spec),
      intrinsics_(IntrinsicsOf(spec)),
      seed_(seed),
      bodies_(robot.bodies),
      R_WG_(robot.bodies.size()),
      solids_(static_cast<int>(solids.size())),
      device_(NewRayDevice()),
      scene_(device_.get()),
      exact_(static_cast<std::size_t>(spec.width) * spec.height) {
  assert(static_cast<int>(exact_.size()) <= DepthFrame::kMaxPixels);
  for (const Solid& solid : solids) {
    scene_.Add(solid);
  }
  for (const Body& body : bodies_) {
    RayGeometry& own = body_scenes_.emplace_back(device_.get());
    own.Add(body.shape, Isometry3d::Identity());
    rtcCommitScene(own.scene());
    RTCGeometry instance = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, own.scene());
    SetTransform(instance, Isometry3d::Identity());
    rtcCommitGeometry(instance);
    rtcAttachGeometry(scene_.scene(), instance);
    rtcReleaseGeometry(instance);
  }
  PassLost();
}

Time DepthCamera::next_stamp() const {
  return Time{FromSeconds(static_cast<double>(sequence_) / spec_.rate_hz)};
}

int DepthCamera::PassDueBefore(Time now) {
  for (int passed = 0;; ++passed) {
    const std::uint32_t due = sequence_++;
    PassLost();
    if (next_stamp() > now) {
      sequence_ = due;
      return passed;
    }
  }
}

/// Whether a sphere may be in the picture: it is not wholly beyond one side of the view's pyramid.
bool DepthCamera::MaySee(const Vector3d& center_S, double radius_m) const {
  const auto inside = [&](double across, double tangent) {
    return across - tangent * center_S.z() <= radius_m * std::sqrt(1 + tangent * tangent);
  };
  return center_S.z() > -radius_m &&
         inside(std::abs(center_S.x()), spec_.width / (2 * intrinsics_.fx)) &&
         inside(std::abs(center_S.y()), spec_.height / (2 * intrinsics_.fy));
}

void DepthCamera::PlaceRobot(const Isometry3d& X_WS, std::span<const Isometry3d> X_WL) {
  const Isometry3d X_SW = X_WS.inverse();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    // Geometry ids are given in the order of attachment.
    RTCGeometry instance = rtcGetGeometry(scene_.scene(), static_cast<unsigned>(solids_ + i));
    const Isometry3d X_WG = X_WL[bodies_[i].link] * bodies_[i].X_LG;
    R_WG_[i] = X_WG.linear().cast<float>();
    // Most of the robot is behind its camera, and an instance costs a ray more than a solid does.
    if (!MaySee(X_SW * X_WG.translation(), BoundingRadius(bodies_[i].shape))) {
      rtcDisableGeometry(instance);
      continue;
    }
    rtcEnableGeometry(instance);
    SetTransform(instance, X_WG);
    rtcCommitGeometry(instance);
  }
  rtcCommitScene(scene_.scene());
}

DepthCamera::ExactPixel DepthCamera::PixelOf(float z_m, std::uint32_t geometry,
                                             std::uint32_t instance, Eigen::Vector3f n,
                                             const Eigen::Vector3f& d_W) const {
  if (geometry == RTC_INVALID_GEOMETRY_ID) {
    return {std::numeric_limits<float>::infinity(), 0, -1};
  }
  int surface = static_cast<int>(geometry);
  if (instance != RTC_INVALID_GEOMETRY_ID) {
    surface = static_cast<int>(instance);
    n = R_WG_[surface - solids_] * n;  // normals of instances come in their own frame
  }
  return {z_m, std::abs(n.dot(d_W)) / (n.norm() * d_W.norm()), surface};
}

const std::vector<DepthCamera::ExactPixel>& DepthCamera::Trace(const Isometry3d& X_WS,
                                                               std::span<const Isometry3d> X_WL) {
  PlaceRobot(X_WS, X_WL);
  const Eigen::Matrix3f R_WS = X_WS.linear().cast<float>();
  const Eigen::Vector3f p_WS = X_WS.translation().cast<float>();
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  const int pixels = static_cast<int>(exact_.size());
  for (int first = 0; first < pixels; first += kPacket) {
    alignas(64) int valid[kPacket];
    alignas(64) RTCRayHit16 packet{};
    Eigen::Vector3f d_W[kPacket];
    for (int k = 0; k < kPacket; ++k) {
      const int pixel = first + k;
      valid[k] = pixel < pixels ? -1 : 0;
      const int v = pixel / intrinsics_.width;
      const int u = pixel % intrinsics_.width;
      // Not of unit length: its z_S is 1, so that the ray's parameter is the depth.
      const Eigen::Vector3f d_S(static_cast<float>((u - intrinsics_.cx) / intrinsics_.fx),
                                static_cast<float>((v - intrinsics_.cy) / intrinsics_.fy), 1);
      d_W[k] = R_WS * d_S;
      packet.ray.org_x[k] = p_WS.x();
      packet.ray.org_y[k] = p_WS.y();
      packet.ray.org_z[k] = p_WS.z();
      packet.ray.dir_x[k] = d_W[k].x();
      packet.ray.dir_y[k] = d_W[k].y();
      packet.ray.dir_z[k] = d_W[k].z();
      packet.ray.tfar[k] = std::numeric_limits<float>::infinity();
      packet.ray.mask[k] = ~0U;
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid, scene_.scene(), &context, &packet);
    for (int k = 0; k < kPacket && first + k < pixels; ++k) {
      const Eigen::Vector3f n(packet.hit.Ng_x[k], packet.hit.Ng_y[k], packet.hit.Ng_z[k]);
      exact_[first + k] =
          PixelOf(packet.ray.tfar[k], packet.hit.geomID[k], packet.hit.instID[0][k], n, d_W[k]);
    }
  }
  return exact_;
}

bool DepthCamera::BesideJump(int pixel) const {
  const int width = intrinsics_.width;
  const int column = pixel % width;
  const float z = exact_[pixel].z_m;
  const float jump = kJump_m + kJumpPerMetre * z;
  const auto differs = [&](int other) { return std::abs(exact_[other].z_m - z) > jump; };
  return (column > 0 && differs(pixel - 1)) || (column + 1 < width && differs(pixel + 1)) ||
         (pixel >= width && differs(pixel - width)) ||
         (pixel + width < static_cast<int>(exact_.size()) && differs(pixel + width));
}

double DepthCamera::TooNear(double z_m, std::uint64_t bits) const {
  if (Unit(bits) >= spec_.below_min_wrong_fraction) {
    return 0;
  }
  const double share = Unit(bits >> 16);
  if ((bits >> 63) != 0) {
    return spec_.z_min_m * kDisparities / (1 + (kDisparities - 1) * share);
  }
  return z_m * (1 + kWrongShare * (2 * share - 1));
}

std::uint16_t DepthCamera::Read(int pixel, std::uint64_t frame_key) const {
  const ExactPixel& exact = exact_[pixel];
  const double z = exact.z_m;
  if (!(z <= spec_.z_max_m)) {
    return 0;
  }
  const std::uint64_t bits = Mix(frame_key + static_cast<std::uint64_t>(pixel));
  if (Unit(bits) < spec_.invalid_fraction) {
    return 0;
  }
  double reading = 0;
  if (z < spec_.z_min_m) {
    reading = TooNear(z, Mix(bits));
  } else {
    const float keep = (exact.cosine - kGrazingAll) / (kGrazingNone - kGrazingAll);
    const bool grazed = static_cast<float>(Unit(bits >> 16)) >= keep;
    if (grazed || ((bits >> 32 & 0xFFFF) < kJumpLost && BesideJump(pixel))) {
      return 0;
    }
    reading = z + spec_.noise_sigma_at_1m * z * z * Normal(bits >> 48);
  }
  const double mm = std::round(reading * 1000);
  return mm > 0 && reading <= spec_.z_max_m ? static_cast<std::uint16_t>(mm) : 0;
}

void DepthCamera::Render(const Isometry3d& X_WS, std::span<const Isometry3d> X_WL,
                         DepthFrame& frame) {
  Trace(X_WS, X_WL);
  frame.stamp = next_stamp();
  frame.sequence = sequence_;
  frame.camera = intrinsics_;
  const std::uint64_t frame_key = Mix(Mix(seed_) + sequence_);
  for (std::size_t i = 0; i < exact_.size(); ++i) {
    frame.depth_mm[i] = Read(static_cast<int>(i), frame_key);
  }
  ++sequence_;
  PassLost();
}

/// To the next frame that comes.
void DepthCamera::PassLost() {
  const std::uint64_t key = Mix(~seed_);
  while (Unit(Mix(key + sequence_)) < spec_.lost_fraction) {
    ++sequence_;
  }
}

}  // namespace pipewright::hil
