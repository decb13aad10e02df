// SPDX-License-Identifier: MIT
#include "hil/cli/primitives_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "perception/primitives/detector.h"
#include "perception/primitives/scatter_detector.h"
#include "perception/primitives/thinning.h"
#include "perception/primitives/unexplained.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDepthSigma_m = 0.004;  ///< at 1 m
constexpr double kPointSigma_m = 0.01;
constexpr double kReach_pixels = 3;  ///< of an image: a surface may be seen at a slant
constexpr int kClusterPoints = 20;

/// The image, thinned to what a DepthView holds. False when no pinhole at the origin saw it.
bool MakeView(const PcdCloud& from, const DepthNoise& noise, DepthView& view, int& used) {
  const auto cloud = std::make_unique<Cloud>();
  int step = 1;
  while ((from.width / step) * (from.height / step) > DepthView::kMaxPixels) {
    ++step;
  }
  cloud->width = from.width / step;
  cloud->height = from.height / step;
  used = 0;
  for (int row = 0; row < cloud->height; ++row) {
    for (int column = 0; column < cloud->width; ++column) {
      const Eigen::Vector3f& p =
          from.points[static_cast<std::size_t>(row * step) * from.width + column * step];
      const int i = row * cloud->width + column;
      cloud->p_SQ[i] = p;
      cloud->valid[i] = static_cast<std::uint8_t>(p.allFinite() && p.z() > 0);
      used += cloud->valid[i];
    }
  }
  return view.Set(*cloud, noise) == Status::kOk && 2 * used > 0;
}

/// Readings of the image that planes and pipes are looked for in.
std::vector<Eigen::Vector3f> Readings(const DepthView& view, double range_m) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < view.size(); ++i) {
    if (view.seen(i) && view.p_S(i).z() <= static_cast<float>(range_m)) {
      points.push_back(view.p_S(i));
    }
  }
  return points;
}

/// Clusters of the points that the run's planes and pipes leave unexplained.
void FindClusters(std::span<const Eigen::Vector3f> points, const PointNoise& noise,
                  const PrimitivesOptions& options, PrimitivesRun& run) {
  std::vector<int> numbers(points.size());
  numbers.resize(Unexplained(points, run.planes, run.pipes, noise, {}, numbers));
  run.unexplained = static_cast<int>(numbers.size());
  const auto far_m = static_cast<float>(ClusterFinder::kFar_reaches * options.reach_m);
  std::vector<Eigen::Vector3f> left;
  for (const int i : numbers) {
    if (points[i].cwiseAbs().maxCoeff() <= far_m) {
      left.push_back(points[i]);
    }
  }
  // Thinning must not part what the reach joins.
  constexpr float kCubesAReach = 4;
  numbers.resize(Thinning::kMaxPoints);
  numbers.resize(std::make_unique<Thinning>()->Pick(
      left, static_cast<float>(options.reach_m) / kCubesAReach, numbers));
  std::vector<Eigen::Vector3f> thinned;
  thinned.reserve(numbers.size());
  for (const int i : numbers) {
    thinned.push_back(left[i]);
  }
  run.clustered = static_cast<int>(thinned.size());
  const auto finder = std::make_unique<ClusterFinder>();
  // Full is said by what was left out; more it cannot be, with points that are near and thinned.
  static_cast<void>(finder->Find(thinned, {options.reach_m, run.spacing_rad, kClusterPoints}));
  run.clusters.assign(finder->clusters().begin(), finder->clusters().end());
  run.clusters_left_out = finder->clusters_refused();
}

Json Numbers(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

template <int n>
Json Numbers(const Mat<n, n>& m) {
  Json rows = Json::array();
  for (int i = 0; i < n; ++i) {
    Json row = Json::array();
    for (int j = 0; j < n; ++j) {
      row.push_back(m(i, j));
    }
    rows.push_back(row);
  }
  return rows;
}

double TiltSigma_rad(const PlaneFit& fit) {
  return std::sqrt(std::max(0.0, fit.covariance.topLeftCorner<3, 3>().trace()));
}

/// Of the plane's distance along n at its centroid.
double OffsetSigma_m(const DetectedPlane& plane) {
  Vec<4> h;
  h << -plane.p_SCentroid, 1;
  return std::sqrt(std::max(0.0, h.dot(plane.fit.covariance * h)));
}

double AxisSigma_rad(const CylinderFit& fit) {
  return std::sqrt(std::max(0.0, fit.covariance.block<3, 3>(3, 3).trace()));
}

double RadiusSigma_m(const CylinderFit& fit) {
  return std::sqrt(std::max(0.0, fit.covariance(6, 6)));
}

}  // namespace

PrimitivesRun RunPrimitives(const PcdCloud& cloud, const PrimitivesOptions& options) {
  PrimitivesRun run;
  run.points =
      static_cast<int>(std::count_if(cloud.points.begin(), cloud.points.end(),
                                     [](const Eigen::Vector3f& p) { return p.allFinite(); }));
  PrimitiveConfig config;
  config.noise.c_1pm = options.sigma_m > 0 ? options.sigma_m : kDepthSigma_m;
  config.plane_range_m = config.pipe_range_m = options.range_m;
  config.pipe_radius_min_m = options.radius_min_m;
  config.pipe_radius_max_m = options.radius_max_m;
  config.pipe_min_length_m = options.length_min_m;
  const auto view = std::make_unique<DepthView>();
  if (cloud.height > 1 && MakeView(cloud, config.noise, *view, run.used)) {
    run.organised = true;
    run.sigma_m = config.noise.c_1pm;
    const auto detector = std::make_unique<PrimitiveDetector>(config, options.seed);
    detector->Detect(*view, {});
    run.planes.assign(detector->planes().begin(), detector->planes().end());
    run.pipes.assign(detector->pipes().begin(), detector->pipes().end());
    const double pixels_rad = std::min(kReach_pixels / static_cast<double>(view->focal()), 0.5);
    run.spacing_rad = options.spacing_rad.value_or(pixels_rad);
    FindClusters(Readings(*view, options.range_m), {.depth = config.noise}, options, run);
    return run;
  }
  ScatterConfig scattered;
  scattered.sigma_m = options.sigma_m > 0 ? options.sigma_m : kPointSigma_m;
  scattered.neighbour_m = options.neighbour_m;
  scattered.pipe_radius_min_m = options.radius_min_m;
  scattered.pipe_radius_max_m = options.radius_max_m;
  scattered.pipe_min_length_m = options.length_min_m;
  run.sigma_m = scattered.sigma_m;
  const auto detector = std::make_unique<ScatterDetector>(scattered, options.seed);
  detector->Detect(cloud.points);
  run.used = detector->points_used();
  run.planes.assign(detector->planes().begin(), detector->planes().end());
  run.pipes.assign(detector->pipes().begin(), detector->pipes().end());
  run.spacing_rad = options.spacing_rad.value_or(0);
  FindClusters(cloud.points, {.depth = {}, .sigma_m = scattered.sigma_m}, options, run);
  return run;
}

Json PrimitivesJson(const PrimitivesRun& run, const PrimitivesOptions& options) {
  Json object{{"file", options.file},
              {"organised", run.organised},
              {"points", run.points},
              {"points_used", run.used},
              {"sigma_m", run.sigma_m},
              {"planes", Json::array()},
              {"pipes", Json::array()},
              {"unexplained", run.unexplained},
              {"clustered", run.clustered},
              {"reach_m", options.reach_m},
              {"spacing_rad", run.spacing_rad},
              {"clusters", Json::array()},
              {"clusters_left_out", run.clusters_left_out}};
  for (const DetectedPlane& plane : run.planes) {
    object["planes"].push_back(
        {{"n", Numbers(plane.fit.n_S)},
         {"d_m", plane.fit.d_m},
         {"covariance", Numbers<4>(plane.fit.covariance)},
         {"tilt_sigma_rad", TiltSigma_rad(plane.fit)},
         {"offset_sigma_m", OffsetSigma_m(plane)},
         {"chi2", plane.fit.chi2},
         {"inliers", plane.fit.count},
         {"centroid_m", Numbers(plane.p_SCentroid)},
         {"extent_m", {plane.hi_m[0] - plane.lo_m[0], plane.hi_m[1] - plane.lo_m[1]}}});
  }
  for (const DetectedPipe& pipe : run.pipes) {
    const CylinderFit& fit = pipe.fit;
    object["pipes"].push_back({{"p_m", Numbers(fit.p_S)},
                               {"l", Numbers(fit.l_S)},
                               {"radius_m", fit.radius_m},
                               {"covariance", Numbers<7>(fit.covariance)},
                               {"axis_sigma_rad", AxisSigma_rad(fit)},
                               {"radius_sigma_m", RadiusSigma_m(fit)},
                               {"chi2", fit.chi2},
                               {"inliers", fit.count},
                               {"lo_m", pipe.lo_m},
                               {"hi_m", pipe.hi_m}});
  }
  for (const PointCluster& cluster : run.clusters) {
    object["clusters"].push_back({{"points", cluster.points},
                                  {"centroid_m", Numbers(cluster.centroid_S)},
                                  {"min_m", Numbers(cluster.min_S)},
                                  {"max_m", Numbers(cluster.max_S)},
                                  {"spread_m", Numbers(cluster.spread_m)}});
  }
  return object;
}

std::string PrimitivesTable(const PrimitivesRun& run, const PrimitivesOptions& options) {
  std::string text =
      fmt::format("{}: {} points, {} used, {}; sigma {} m{}\n", options.file, run.points, run.used,
                  run.organised ? "as a depth image" : "unorganised", run.sigma_m,
                  run.organised ? " at 1 m" : "");
  for (const DetectedPlane& plane : run.planes) {
    const Vector3d& n = plane.fit.n_S;
    text += fmt::format(
        "plane  n ({:.4f} {:.4f} {:.4f}) ± {:.4f} rad  d {:.4f} ± {:.4f} m  {:.2f} x {:.2f} m  "
        "{} points  chi2 {:.2f}\n",
        n.x(), n.y(), n.z(), TiltSigma_rad(plane.fit), plane.fit.d_m, OffsetSigma_m(plane),
        plane.hi_m[0] - plane.lo_m[0], plane.hi_m[1] - plane.lo_m[1], plane.fit.count,
        plane.fit.chi2);
  }
  for (const DetectedPipe& pipe : run.pipes) {
    const Vector3d& p = pipe.fit.p_S;
    const Vector3d& l = pipe.fit.l_S;
    text += fmt::format(
        "pipe   p ({:.4f} {:.4f} {:.4f}) m  l ({:.4f} {:.4f} {:.4f}) ± {:.4f} rad  r {:.4f} ± "
        "{:.4f} m  length {:.2f} m  {} points  chi2 {:.2f}\n",
        p.x(), p.y(), p.z(), l.x(), l.y(), l.z(), AxisSigma_rad(pipe.fit), pipe.fit.radius_m,
        RadiusSigma_m(pipe.fit), pipe.hi_m - pipe.lo_m, pipe.fit.count, pipe.fit.chi2);
  }
  for (const PointCluster& cluster : run.clusters) {
    const Vector3d& p = cluster.centroid_S;
    const Vector3d box = cluster.max_S - cluster.min_S;
    text += fmt::format(
        "cluster  p ({:.4f} {:.4f} {:.4f}) m  box {:.2f} x {:.2f} x {:.2f} m  {} points\n", p.x(),
        p.y(), p.z(), box.x(), box.y(), box.z(), cluster.points);
  }
  text += fmt::format("{} planes, {} pipes, {} clusters of {} unexplained points",
                      run.planes.size(), run.pipes.size(), run.clusters.size(), run.unexplained);
  if (run.clustered < run.unexplained) {
    text += fmt::format(", thinned to {}", run.clustered);
  }
  if (run.clusters_left_out > 0) {
    text += fmt::format("; {} smaller clusters left out", run.clusters_left_out);
  }
  return text + "\n";
}

}  // namespace pipewright::hil
