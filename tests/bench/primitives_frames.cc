// SPDX-License-Identifier: MIT
#include "tests/bench/primitives_frames.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <limits>
#include <memory>
#include <span>

#include "hil/cli/heap_watch.h"
#include "perception/cloud/cluster_finder.h"
#include "perception/primitives/pipe_finder.h"
#include "perception/primitives/plane_finder.h"
#include "perception/primitives/track.h"
#include "perception/primitives/unexplained.h"

namespace pipewright::bench {
namespace {

constexpr double kSamePlane = 0.1;  // rad and m: farther off, it is another plane
constexpr double kSamePipe_m = 0.03;
constexpr double kSamePipe_rad = 0.2;

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

  /// Clusters of the view's readings that its primitives leave unexplained.
  void Cluster() {
    int count = 0;
    for (int i = 0; i < view->size(); ++i) {
      if (view->seen(i)) {
        (*readings)[count++] = view->p_S(i);
      }
    }
    count =
        Unexplained({readings->data(), static_cast<std::size_t>(count)}, FoundPlanes(),
                    {pipes->found().begin(), pipes->found().end()}, {.depth = noise}, {}, *numbers);
    for (int k = 0; k < count; ++k) {
      (*readings)[k] = (*readings)[(*numbers)[k]];
    }
    constexpr double kPixels = 3;
    const Status status =
        clusters->Find({readings->data(), static_cast<std::size_t>(count)},
                       {.spacing_rad = kPixels / static_cast<double>(view->focal())});
    clusters_found = status == Status::kOk ? clusters->clusters().size() : 0;
  }

  DepthNoise noise;
  CloudConfig cloud_config;
  CloudCounts counts;
  std::unique_ptr<DepthFrame> frame = std::make_unique<DepthFrame>();
  std::unique_ptr<Cloud> cloud = std::make_unique<Cloud>();
  std::unique_ptr<DepthView> view = std::make_unique<DepthView>();
  std::unique_ptr<PlaneFinder> planes;
  std::unique_ptr<PipeFinder> pipes;
  std::unique_ptr<std::array<Eigen::Vector3f, DepthView::kMaxPixels>> readings =
      std::make_unique<std::array<Eigen::Vector3f, DepthView::kMaxPixels>>();
  std::unique_ptr<std::array<int, DepthView::kMaxPixels>> numbers =
      std::make_unique<std::array<int, DepthView::kMaxPixels>>();
  std::unique_ptr<ClusterFinder> clusters = std::make_unique<ClusterFinder>();
  int clusters_found = 0;
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
    double least[5] = {1e9, 1e9, 1e9, 1e9, 1e9};
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
      const double clusters = Time_ms([&] { run.Cluster(); });
      least[0] = std::min(least[0], cloud);
      least[1] = std::min(least[1], view);
      least[2] = std::min(least[2], planes);
      least[3] = std::min(least[3], pipes);
      least[4] = std::min(least[4], clusters);
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
    times.clusters_ms.push_back(least[4]);
    times.all_ms.push_back(all);
    times.planes += run.planes->found().size();
    times.pipes += run.pipes->found().size();
    times.clusters += run.clusters_found;
  }
  return times;
}

}  // namespace pipewright::bench
