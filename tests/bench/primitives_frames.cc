// SPDX-License-Identifier: MIT
#include "tests/bench/primitives_frames.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <memory>
#include <numbers>
#include <span>

#include "hil/cli/heap_watch.h"
#include "hil/sensors/depth_camera.h"
#include "perception/primitives/pipe_finder.h"
#include "perception/primitives/plane_finder.h"
#include "perception/primitives/track.h"
#include "platform/core/rng.h"

namespace pipewright::bench {
namespace {

constexpr int kFramesPerRoom = 10;
constexpr double kSamePlane = 0.1;  // rad and m: farther off, it is another plane
constexpr double kSamePipe_m = 0.03;
constexpr double kSamePipe_rad = 0.2;

struct TruePlane {
  Vector3d n_W;
  double d_m;
};
struct TruePipe {
  Vector3d p_W;
  Vector3d l_W;
  double radius_m;
};

struct Room {
  std::vector<hil::Solid> solids;
  std::vector<TruePlane> planes;
  std::vector<TruePipe> pipes;
  Vector3d half_m = Vector3d::Zero();
};

Matrix3d WithZ(const Vector3d& z) {
  Matrix3d R;
  R.col(2) = z;
  R.col(0) = z.unitOrthogonal();
  R.col(1) = z.cross(R.col(0));
  return R;
}

void AddPlane(const Vector3d& n_W, double d_m, Room& room) {
  hil::Solid solid;
  solid.kind = hil::SolidKind::kPlane;
  solid.X_WG.linear() = WithZ(n_W);
  solid.X_WG.translation() = d_m * n_W;
  room.solids.push_back(solid);
  room.planes.push_back({n_W, d_m});
}

void AddPipe(const Vector3d& p_W, const Vector3d& l_W, double radius_m, double length_m,
             Room& room) {
  hil::Solid solid;
  solid.kind = hil::SolidKind::kCylinder;
  solid.shape = hil::Shape::Cylinder(radius_m, length_m);
  solid.X_WG.linear() = WithZ(l_W);
  solid.X_WG.translation() = p_W;
  room.solids.push_back(solid);
  room.pipes.push_back({p_W, l_W, radius_m});
}

Vector3d Direction(Rng& rng) {
  return Vector3d(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
}

/// Four walls, not quite square, floor and ceiling; up to three pipes that hang free.
Room MakeRoom(const FrameCase& c, Rng& rng) {
  Room room;
  const double turn = rng.Uniform(-std::numbers::pi, std::numbers::pi);
  for (int axis = 0; axis < 2; ++axis) {
    room.half_m[axis] = rng.Uniform(c.room_lo_m, c.room_hi_m);
  }
  room.half_m.z() = rng.Uniform(0.8, 1.5);
  for (int wall = 0; wall < 4; ++wall) {
    const double yaw = turn + wall * std::numbers::pi / 2 + 0.05 * rng.Normal();
    AddPlane({-std::cos(yaw), -std::sin(yaw), 0}, -room.half_m[wall % 2], room);
  }
  AddPlane(Vector3d::UnitZ(), -room.half_m.z(), room);
  AddPlane(-Vector3d::UnitZ(), -room.half_m.z(), room);
  const int pipes = rng.Index(4);
  for (int k = 0; k < pipes; ++k) {
    const double reach = 0.5 * room.half_m.head<2>().minCoeff();
    const Vector3d p_W{rng.Uniform(-reach, reach), rng.Uniform(-reach, reach),
                       rng.Uniform(-0.5, 0.5)};
    AddPipe(p_W, Direction(rng), rng.Uniform(0.025, 0.14), rng.Uniform(0.5, 3.0), room);
  }
  return room;
}

Isometry3d LookingAlong(const Vector3d& eye_W, const Vector3d& z_W, double roll_rad) {
  Isometry3d X_WS = Isometry3d::Identity();
  X_WS.linear() = WithZ(z_W) * Eigen::AngleAxisd(roll_rad, Vector3d::UnitZ()).toRotationMatrix();
  X_WS.translation() = eye_W;
  return X_WS;
}

bool Free(const Room& room, const Vector3d& p_W) {
  constexpr double kClear_m = 0.2;
  return std::all_of(room.solids.begin(), room.solids.end(),
                     [&](const hil::Solid& solid) { return hil::Distance(solid, p_W) > kClear_m; });
}

/// Half of the poses face a pipe from the case's distances, half anything from anywhere.
Isometry3d MakePose(const FrameCase& c, const Room& room, Rng& rng) {
  for (;;) {
    const double roll_rad = rng.Uniform(-std::numbers::pi, std::numbers::pi);
    Vector3d eye_W = Vector3d::Zero();
    Vector3d target_W = Vector3d::Zero();
    if (!room.pipes.empty() && rng.Uniform() < 0.5) {
      const TruePipe& pipe = room.pipes[rng.Index(static_cast<int>(room.pipes.size()))];
      const Vector3d side = pipe.l_W.cross(Direction(rng)).normalized();
      target_W = pipe.p_W + rng.Uniform(-0.2, 0.2) * pipe.l_W;
      eye_W = target_W + (pipe.radius_m + rng.Uniform(c.near_m, c.far_m)) * side +
              rng.Uniform(-0.3, 0.3) * pipe.l_W;
      target_W += 0.1 * Direction(rng);
    } else {
      for (int axis = 0; axis < 3; ++axis) {
        eye_W[axis] = rng.Uniform(-0.8, 0.8) * room.half_m[axis];
      }
      target_W = eye_W + Direction(rng);
    }
    if (Free(room, eye_W)) {
      return LookingAlong(eye_W, (target_W - eye_W).normalized(), roll_rad);
    }
  }
}

/// Rooms, poses and the camera in them; each frame is new.
class FrameSource {
 public:
  FrameSource(const FrameCase& c, std::uint64_t seed) : case_(c), rng_(seed, 7), seed_(seed) {}

  void Next(DepthFrame& frame) {
    if (count_ % kFramesPerRoom == 0) {
      room_ = MakeRoom(case_, rng_);
      camera_ = std::make_unique<hil::DepthCamera>(case_.camera, room_.solids, hil::RobotBodies{},
                                                   seed_ * 1000003 + count_);
    }
    ++count_;
    X_WS_ = MakePose(case_, room_, rng_);
    camera_->Render(X_WS_, {}, frame);
  }
  const Room& room() const { return room_; }
  const Isometry3d& X_WS() const { return X_WS_; }

 private:
  FrameCase case_;
  Rng rng_;
  std::uint64_t seed_;
  std::uint64_t count_ = 0;
  Room room_;
  std::unique_ptr<hil::DepthCamera> camera_;
  Isometry3d X_WS_ = Isometry3d::Identity();
};

/// What is between a depth frame and its primitives.
struct Pipeline {
  explicit Pipeline(const FrameCase& c, std::uint64_t seed)
      : planes(std::make_unique<PlaneFinder>(Config(c), seed)),
        pipes(std::make_unique<PipeFinder>(Config(c), seed)) {
    noise = Config(c).noise;
    cloud_config.stride = c.stride;
  }
  static PrimitiveConfig Config(const FrameCase& c) {
    PrimitiveConfig config;
    config.noise.c_1pm = c.camera.noise_sigma_at_1m;
    return config;
  }

  std::span<const DetectedPlane> FoundPlanes() const {
    return {planes->found().begin(), planes->found().end()};
  }

  DepthNoise noise;
  CloudConfig cloud_config;
  CloudCounts counts;
  std::unique_ptr<DepthFrame> frame = std::make_unique<DepthFrame>();
  std::unique_ptr<Cloud> cloud = std::make_unique<Cloud>();
  std::unique_ptr<DepthView> view = std::make_unique<DepthView>();
  std::unique_ptr<PlaneFinder> planes;
  std::unique_ptr<PipeFinder> pipes;
};

template <int n>
double Nees(const Vec<n>& error, const Mat<n, n>& covariance) {
  return error.dot(Eigen::LDLT<Mat<n, n>>(covariance).solve(error));
}

void AddPlaneError(const DetectedPlane& found, const Room& room, const Isometry3d& X_WS,
                   FrameErrors& errors) {
  Vec<4> error = Vec<4>::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (const TruePlane& truth : room.planes) {
    Vec<4> e;
    e << found.fit.n_S - X_WS.linear().transpose() * truth.n_W,
        found.fit.d_m - (truth.d_m - truth.n_W.dot(X_WS.translation()));
    const double off = e.head<3>().norm() + std::abs(e(3));
    if (off < least) {
      least = off;
      error = e;
    }
  }
  if (least > kSamePlane) {
    ++errors.wrong_planes;
    return;
  }
  // Tilts and the offset at the centroid: coordinates of the manifold.
  Mat<3, 4> H = Mat<3, 4>::Zero();
  H.block<1, 3>(0, 0) = found.e1_S.transpose();
  H.block<1, 3>(1, 0) = found.e2_S.transpose();
  H.block<1, 3>(2, 0) = -found.p_SCentroid.transpose();
  H(2, 3) = 1;
  errors.plane.push_back(Nees<3>(H * error, H * found.fit.covariance * H.transpose()));
}

void AddPipeError(const DetectedPipe& found, const Room& room, const Isometry3d& X_WS,
                  FrameErrors& errors) {
  const CylinderFit& fit = found.fit;
  const Isometry3d X_SW = X_WS.inverse();
  for (const TruePipe& truth : room.pipes) {
    Vector3d l_S = X_SW.linear() * truth.l_W;
    l_S = fit.l_S.dot(l_S) < 0 ? Vector3d(-l_S) : l_S;
    const Vector3d p_S = X_SW * truth.p_W;
    // The true axis where it passes beside the fit's p.
    const Vector3d at_S = p_S + fit.l_S.dot(fit.p_S - p_S) / fit.l_S.dot(l_S) * l_S;
    Vec<7> error;
    error << fit.p_S - at_S, fit.l_S - l_S, fit.radius_m - truth.radius_m;
    if (error.head<3>().norm() > kSamePipe_m || error.segment<3>(3).norm() > kSamePipe_rad) {
      continue;
    }
    PipeEstimate pipe;
    pipe.l_W = fit.l_S;
    const Mat<7, 5> G = PipeTangent(pipe);
    const Vec<5> x = G.transpose() * error;
    const Mat<5, 5> P = G.transpose() * fit.covariance * G;
    errors.axis.push_back(Nees<4>(x.head<4>(), P.topLeftCorner<4, 4>()));
    errors.radius.push_back(x(4) * x(4) / P(4, 4));
    errors.pipe.push_back(Nees<5>(x, P));
    return;
  }
  ++errors.wrong_pipes;
}

template <typename Work>
double Time_ms(const Work& work) {
  const std::clock_t start = std::clock();
  work();
  return 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

}  // namespace

void FrameErrors::operator+=(const FrameErrors& other) {
  const auto append = [](std::vector<double>& to, const std::vector<double>& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(plane, other.plane);
  append(axis, other.axis);
  append(radius, other.radius);
  append(pipe, other.pipe);
  frames += other.frames;
  wrong_planes += other.wrong_planes;
  wrong_pipes += other.wrong_pipes;
}

FrameErrors MeasureErrors(const FrameCase& c, int frames, std::uint64_t seed) {
  FrameErrors errors;
  FrameSource source(c, seed);
  Pipeline run(c, seed);
  for (; errors.frames < frames; ++errors.frames) {
    source.Next(*run.frame);
    if (MakeCloud(*run.frame, source.X_WS(), {}, run.cloud_config, *run.cloud, run.counts) !=
            Status::kOk ||
        run.view->Set(*run.cloud, run.noise) != Status::kOk) {
      continue;
    }
    run.planes->Find(*run.view, {});
    run.pipes->Find(*run.view, {}, run.FoundPlanes());
    for (const DetectedPlane& plane : run.planes->found()) {
      AddPlaneError(plane, source.room(), source.X_WS(), errors);
    }
    for (const DetectedPipe& pipe : run.pipes->found()) {
      AddPipeError(pipe, source.room(), source.X_WS(), errors);
    }
  }
  return errors;
}

FrameTimes MeasureTimes(const FrameCase& c, int frames, int passes, std::uint64_t seed) {
  FrameTimes times;
  FrameSource source(c, seed);
  Pipeline run(c, seed);
  for (int k = 0; k < frames; ++k) {
    source.Next(*run.frame);
    double least[4] = {1e9, 1e9, 1e9, 1e9};
    double all = 1e9;
    const hil::HeapWatch heap;
    for (int pass = 0; pass < passes; ++pass) {
      Status status = Status::kOk;
      const double cloud = Time_ms([&] {
        status = MakeCloud(*run.frame, source.X_WS(), {}, run.cloud_config, *run.cloud, run.counts);
      });
      const double view = Time_ms(
          [&] { status = status == Status::kOk ? run.view->Set(*run.cloud, run.noise) : status; });
      if (status != Status::kOk) {
        continue;
      }
      const double planes = Time_ms([&] { run.planes->Find(*run.view, {}); });
      const double pipes = Time_ms([&] { run.pipes->Find(*run.view, {}, run.FoundPlanes()); });
      least[0] = std::min(least[0], cloud);
      least[1] = std::min(least[1], view);
      least[2] = std::min(least[2], planes);
      least[3] = std::min(least[3], pipes);
      all = std::min(all, cloud + view + planes + pipes);
    }
    times.heap_allocations += heap.allocations();
    if (all > 1e8) {
      continue;  // a view of nothing
    }
    times.cloud_ms.push_back(least[0]);
    times.view_ms.push_back(least[1]);
    times.planes_ms.push_back(least[2]);
    times.pipes_ms.push_back(least[3]);
    times.all_ms.push_back(all);
    times.planes += run.planes->found().size();
    times.pipes += run.pipes->found().size();
  }
  return times;
}

}  // namespace pipewright::bench
