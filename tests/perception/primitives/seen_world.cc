// SPDX-License-Identifier: MIT
#include "seen_world.h"

#include <cmath>
#include <limits>

namespace pipewright::test {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

double CastPlane(const TruePlane& plane, const Vector3d& p, const Vector3d& v) {
  const double towards = -plane.n_W.dot(v);
  const double height = plane.n_W.dot(p) - plane.d_m;
  return towards > 1e-9 && height > 0 ? height / towards : kNone;
}

double CastPipe(const TruePipe& pipe, const Vector3d& p, const Vector3d& v) {
  const Vector3d axis = pipe.to_W - pipe.from_W;
  const double length = axis.norm();
  const Vector3d l = axis / length;
  const Vector3d w = p - pipe.from_W;
  const Vector3d a = v - l.dot(v) * l;
  const Vector3d b = w - l.dot(w) * l;
  const double A = a.dot(a);
  const double B = a.dot(b);
  const double C = b.dot(b) - pipe.radius_m * pipe.radius_m;
  const double root = B * B - A * C;
  if (A < 1e-12 || root < 0 || C < 0) {
    return kNone;
  }
  const double t = (-B - std::sqrt(root)) / A;
  const double s = l.dot(w + t * v);
  return t > 0 && s >= 0 && s <= length ? t : kNone;
}

double CastBall(const TrueBall& ball, const Vector3d& p, const Vector3d& v) {
  const Vector3d w = p - ball.c_W;
  const double B = w.dot(v);
  const double root = B * B - (w.dot(w) - ball.radius_m * ball.radius_m);
  const double t = root < 0 ? -1 : -B - std::sqrt(root);
  return t > 0 ? t : kNone;
}

}  // namespace

double World::Cast(const Vector3d& p_W, const Vector3d& direction_W) const {
  double nearest = kNone;
  for (const TruePlane& plane : planes) {
    nearest = std::min(nearest, CastPlane(plane, p_W, direction_W));
  }
  for (const TruePipe& pipe : pipes) {
    nearest = std::min(nearest, CastPipe(pipe, p_W, direction_W));
  }
  for (const TrueBall& ball : balls) {
    nearest = std::min(nearest, CastBall(ball, p_W, direction_W));
  }
  return nearest;
}

Isometry3d LookingAt(const Vector3d& eye, const Vector3d& target) {
  const Vector3d z = (target - eye).normalized();
  const Vector3d down =
      std::abs(z.z()) < 0.95 ? Vector3d(-Vector3d::UnitZ()) : Vector3d(Vector3d::UnitX());
  const Vector3d x = down.cross(z).normalized();
  Isometry3d X_WS = Isometry3d::Identity();
  X_WS.linear().col(0) = x;
  X_WS.linear().col(1) = z.cross(x);
  X_WS.linear().col(2) = z;
  X_WS.translation() = eye;
  return X_WS;
}

void See(const World& world, const Isometry3d& X_WS, const Lens& lens, const DepthNoise& noise,
         Rng& rng, Cloud& cloud) {
  cloud.X_WS = X_WS;
  cloud.width = lens.width;
  cloud.height = lens.height;
  cloud.valid_count = 0;
  const double f = lens.width / 2.0 / std::tan(lens.fov_rad / 2);
  for (int i = 0; i < lens.width * lens.height; ++i) {
    cloud.valid[i] = 0;
    const Vector3d ray{(i % lens.width - (lens.width - 1) / 2.0) / f,
                       (i / lens.width - (lens.height - 1) / 2.0) / f, 1};
    const double t = world.Cast(X_WS.translation(), X_WS.linear() * ray.normalized());
    const double exact = t / ray.norm();
    const double spread = rng.Normal();
    if (rng.Uniform() < 0.01 || !(exact < lens.z_max_m)) {
      continue;
    }
    double z = exact + noise.c_1pm * exact * exact * spread;
    if (noise.step_m > 0) {
      z = std::round(z / noise.step_m) * noise.step_m;
    }
    if (z >= lens.z_min_m && z <= lens.z_max_m) {
      cloud.p_SQ[i] = (z * ray).cast<float>();
      cloud.valid[i] = 1;
      ++cloud.valid_count;
    }
  }
}

World Cell() {
  World world;
  world.planes = {{Vector3d::UnitZ(), 0},     {-Vector3d::UnitX(), -1.5}, {Vector3d::UnitY(), 0},
                  {-Vector3d::UnitY(), -1.5}, {Vector3d::UnitX(), -2.0},  {-Vector3d::UnitZ(), -3}};
  return world;
}

}  // namespace pipewright::test
