// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "perception/primitives/plane_finder.h"

namespace pipewright {
namespace {

constexpr double kMinFacing = 0.08;  // cosine to the view below which a plane is seen edge-on
constexpr int kInnerSupport = 8;     // of 9 pixels
constexpr double kCornerSigmas = 5;
constexpr double kBorder_m = 0.1;

}  // namespace

Eigen::Matrix<double, 3, 2> RectangleAxes(const Vector3d& n, const Vector3d& up,
                                          const Vector3d& forward) {
  constexpr double kNearlyLevel = 0.9;
  Eigen::Matrix<double, 3, 2> axes;
  const bool level = std::abs(n.dot(up)) > kNearlyLevel;
  const Vector3d e1 = level ? Vector3d(forward - n.dot(forward) * n) : Vector3d(up.cross(n));
  axes.col(0) = e1.normalized();
  axes.col(1) = n.cross(axes.col(0));
  return axes;
}

/// The fit without readings at the rim of the plane's parts or near a plane that is known already:
/// in a corner these are of the other plane, and all on one side.
void PlaneFinder::Polish(const DepthView& view, int count, DetectedPlane& plane) {
  const auto limit = static_cast<float>(kCornerSigmas);
  int inner = 0;
  for (int k = 0; k < count; ++k) {
    const int i = inlier_[k];
    bool corner = false;
    for (const DetectedPlane& other : found_) {
      const Eigen::Vector3f m = InverseDepth(other.fit);
      const float residual = view.inverse_z(i) - (m.x() * view.x(i) + m.y() * view.y(i) + m.z());
      corner |= std::abs(residual) * view.inverse_sigma(i) < limit;
    }
    if (!corner && Support(view, i) >= kInnerSupport) {
      point_[inner++] = point_[k];
    }
  }
  const auto fitted = FitPlane({point_.data(), static_cast<std::size_t>(inner)}, config_.noise);
  if (2 * inner >= count && fitted.ok()) {  // else it is too thin to be choosy
    plane.fit = *fitted;
    const double off_m = plane.fit.n_S.dot(plane.p_SCentroid) - plane.fit.d_m;
    plane.p_SCentroid -= off_m * plane.fit.n_S;
    plane.e1_S = (plane.e1_S - plane.fit.n_S.dot(plane.e1_S) * plane.fit.n_S).normalized();
    plane.e2_S = plane.fit.n_S.cross(plane.e1_S);
  }
}

/// Pixels of the plane among a pixel and its eight neighbours.
int PlaneFinder::Support(const DepthView& view, int i) const {
  const int width = view.width();
  const int column = i % width;
  const int row = i / width;
  int support = 0;
  for (int r = std::max(0, row - 1); r <= std::min(view.height() - 1, row + 1); ++r) {
    for (int c = std::max(0, column - 1); c <= std::min(width - 1, column + 1); ++c) {
      support += mark_[r * width + c] == 3;
    }
  }
  return support;
}

/// The rectangle about the readings that are kept, from those with support on most sides.
bool PlaneFinder::Bound(const DepthView& view, int count, DetectedPlane& plane) const {
  if (count < static_cast<int>(config_.plane_min_share * view.size())) {
    return false;
  }
  const Eigen::Matrix3d R_SW = view.X_WS().linear().transpose();
  const auto axes = RectangleAxes(plane.fit.n_S, R_SW.col(2), R_SW.col(0));
  plane.e1_S = axes.col(0);
  plane.e2_S = axes.col(1);
  Vector3d sum = Vector3d::Zero();
  double lo[2] = {1e9, 1e9};
  double hi[2] = {-1e9, -1e9};
  double area_m2 = 0;
  double sigma_m = 0;
  double facing = 0;
  for (int k = 0; k < count; ++k) {
    const int i = inlier_[k];
    const Vector3d ray(view.x(i), view.y(i), 1);
    const double z = plane.fit.d_m / plane.fit.n_S.dot(ray);
    const Vector3d p = z * ray;
    const double cosine = -plane.fit.n_S.dot(ray);
    sum += p;
    area_m2 += z * z / (view.focal() * view.focal() * std::max(cosine, 1e-3));
    sigma_m += z * z * config_.noise.SigmaInverse(1 / z);
    facing += cosine / std::sqrt(ray.squaredNorm());
    const int support = Support(view, i);
    for (int a = 0; a < 2 && support >= 4; ++a) {
      lo[a] = std::min(lo[a], axes.col(a).dot(p));
      hi[a] = std::max(hi[a], axes.col(a).dot(p));
    }
  }
  plane.p_SCentroid = sum / count;
  for (int a = 0; a < 2; ++a) {
    plane.lo_m[a] = lo[a] - axes.col(a).dot(plane.p_SCentroid);
    plane.hi_m[a] = hi[a] - axes.col(a).dot(plane.p_SCentroid);
  }
  const double shorter_m = std::min(hi[0] - lo[0], hi[1] - lo[1]);
  const double least_m =
      std::max(config_.plane_min_extent_m, config_.plane_extent_sigmas * sigma_m / count);
  const double tilt_rad = std::sqrt(plane.fit.covariance.topLeftCorner<3, 3>().trace());
  return shorter_m >= least_m && facing / count >= kMinFacing &&
         tilt_rad <= config_.plane_tilt_sigma_max_rad &&
         area_m2 >= config_.plane_min_fill * (hi[0] - lo[0]) * (hi[1] - lo[1]);
}

/// Marks all readings near the plane and about its rectangle as of a plane: no pipe is made of
/// them.
void PlaneFinder::Claim(DepthView& view, const DetectedPlane& plane) const {
  for (int i = 0; i < view.size(); ++i) {
    if (view.use(i) != DepthView::Use::kFree) {
      continue;
    }
    const Vector3d ray(view.x(i), view.y(i), 1);
    const double w = view.inverse_z(i);
    const Vector3d p_S = ray / w;
    const double off_m = std::abs(plane.fit.n_S.dot(p_S) - plane.fit.d_m);
    const double sigma_m =
        SurfaceSigma(p_S, plane.fit.n_S, config_.noise) * config_.plane_clear_sigmas;
    if (off_m > std::max(sigma_m, config_.plane_clear_m)) {
      continue;
    }
    const Vector3d q = p_S - plane.p_SCentroid;
    const double a = plane.e1_S.dot(q);
    const double b = plane.e2_S.dot(q);
    if (a >= plane.lo_m[0] - kBorder_m && a <= plane.hi_m[0] + kBorder_m &&
        b >= plane.lo_m[1] - kBorder_m && b <= plane.hi_m[1] + kBorder_m) {
      view.set_use(i, DepthView::Use::kPlane);
    }
  }
}

}  // namespace pipewright
