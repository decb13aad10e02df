// SPDX-License-Identifier: MIT
#include "perception/primitives/plane_finder.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace pipewright {
namespace {

constexpr int kAttempts = 12;  // hypotheses refined a frame
constexpr int kRefinements = 3;
constexpr int kMinPart = 20;      // pixels: smaller islands of a plane do not count
constexpr int kInnerSupport = 8;  // of 9 pixels
constexpr double kCornerSigmas = 5;
constexpr double kPartShare = 0.05;
constexpr double kMinFacing = 0.08;  // cosine to the view below which a plane is seen edge-on

Eigen::Vector3f InverseDepthForm(const PlaneFit& fit) { return (fit.n_S / fit.d_m).cast<float>(); }

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

void PlaneFinder::Find(DepthView& view, std::span<const PlaneFit> hints) {
  found_.clear();
  for (int i = 0; i < view.size(); ++i) {
    const bool far = view.inverse_z(i) * static_cast<float>(config_.plane_range_m) < 1;
    barred_[i] = static_cast<std::uint8_t>(view.use(i) != DepthView::Use::kFree || far);
  }
  Sample(view);
  for (const PlaneFit& hint : hints) {
    if (hint.d_m < 0) {
      const Eigen::Vector3f m = InverseDepthForm(hint);
      Consider(view, {m, Score(m)});
    }
  }
  for (int attempt = 0; attempt < kAttempts && !found_.full(); ++attempt) {
    Sample(view);
    const Hypothesis best = Draw(view);
    if (best.score < 8) {
      return;
    }
    if (!Consider(view, best)) {
      Bar(view);
    }
  }
}

/// Evenly spaced readings among those that are free and not barred.
void PlaneFinder::Sample(const DepthView& view) {
  int free = 0;
  for (int i = 0; i < view.size(); ++i) {
    stack_[free] = i;
    free += barred_[i] == 0;
  }
  samples_ = std::min(free, kMaxSamples);
  for (int k = 0; k < samples_; ++k) {
    const int i = stack_[static_cast<long>(k) * free / samples_];
    sample_[k] = i;
    x_[k] = view.x(i);
    y_[k] = view.y(i);
    w_[k] = view.inverse_z(i);
    inverse_sigma_[k] = view.inverse_sigma(i);
  }
}

int PlaneFinder::Score(const Eigen::Vector3f& m) const {
  const auto limit = static_cast<float>(config_.inlier_sigmas);
  int score = 0;
  for (int k = 0; k < samples_; ++k) {
    const float residual = w_[k] - (m.x() * x_[k] + m.y() * y_[k] + m.z());
    score += std::abs(residual) * inverse_sigma_[k] < limit;
  }
  return score;
}

PlaneFinder::Hypothesis PlaneFinder::Draw(const DepthView& view) {
  Hypothesis best;
  if (samples_ < 16) {
    return best;
  }
  const int reach = std::max(3, view.width() / 6);
  const auto near = [&](int i) {
    const int column = i % view.width() + rng_.Index(2 * reach + 1) - reach;
    const int row = i / view.width() + rng_.Index(2 * reach + 1) - reach;
    const bool inside = column >= 0 && column < view.width() && row >= 0 && row < view.height();
    const int j = inside ? row * view.width() + column : i;
    return barred_[j] == 0 ? j : i;
  };
  for (int draw = 0; draw < config_.plane_draws; ++draw) {
    const int a = sample_[rng_.Index(samples_)];
    const int b = near(a);
    const int c = near(a);
    Eigen::Matrix3f rays;
    rays << view.x(a), view.y(a), 1, view.x(b), view.y(b), 1, view.x(c), view.y(c), 1;
    const float determinant = rays.determinant();
    if (std::abs(determinant) < 1e-3F) {
      continue;
    }
    const Eigen::Vector3f w(view.inverse_z(a), view.inverse_z(b), view.inverse_z(c));
    const Eigen::Vector3f m = rays.inverse() * w;
    if (const int score = Score(m); score > best.score) {
      best = {m, score};
    }
  }
  return best;
}

/// Marks the readings within `sigmas` of the plane with 1; their number.
int PlaneFinder::Collect(const DepthView& view, const Eigen::Vector3f& m, double sigmas) {
  const auto limit = static_cast<float>(sigmas);
  int count = 0;
  for (int i = 0; i < view.size(); ++i) {
    const float residual = view.inverse_z(i) - (m.x() * view.x(i) + m.y() * view.y(i) + m.z());
    const bool on = barred_[i] == 0 && std::abs(residual) * view.inverse_sigma(i) < limit;
    mark_[i] = static_cast<std::uint8_t>(on);
    if (on) {
      inlier_[count] = i;
      point_[count] = view.p_S(i);
      ++count;
    }
  }
  return count;
}

bool PlaneFinder::Refine(const DepthView& view, Eigen::Vector3f m, PlaneFit& fit) {
  const int least = static_cast<int>(config_.plane_min_share * view.size());
  for (int k = 0; k < kRefinements; ++k) {
    int count = Collect(view, m, config_.inlier_sigmas);
    if (k > 0) {
      count = KeepLargeParts(view, count);
    }
    const auto fitted =
        count < least ? Result<PlaneFit>(Status::kInfeasible)
                      : FitPlane({point_.data(), static_cast<std::size_t>(count)}, config_.noise);
    if (!fitted.ok()) {
      return false;
    }
    fit = *fitted;
    m = InverseDepthForm(fit);
  }
  return true;
}

/// Drops islands of marked pixels that are too small; marks what stays with 3 and packs it.
int PlaneFinder::KeepLargeParts(const DepthView& view, int count) {
  const int least = std::max(kMinPart, static_cast<int>(kPartShare * count));
  const int width = view.width();
  int kept = 0;
  for (int k = 0; k < count; ++k) {
    if (mark_[inlier_[k]] != 1) {
      continue;
    }
    int size = 0;
    stack_[size++] = inlier_[k];
    mark_[inlier_[k]] = 2;
    for (int next = 0; next < size; ++next) {
      const int column = stack_[next] % width;
      const int row = stack_[next] / width;
      for (int r = std::max(0, row - 1); r <= std::min(view.height() - 1, row + 1); ++r) {
        for (int c = std::max(0, column - 1); c <= std::min(width - 1, column + 1); ++c) {
          if (mark_[r * width + c] == 1) {
            mark_[r * width + c] = 2;
            stack_[size++] = r * width + c;
          }
        }
      }
    }
    for (int j = 0; j < size; ++j) {
      mark_[stack_[j]] = size >= least ? 3 : 0;
    }
  }
  for (int k = 0; k < count; ++k) {
    if (mark_[inlier_[k]] == 3) {
      point_[kept] = point_[k];
      inlier_[kept++] = inlier_[k];
    }
  }
  return kept;
}

/// Whether a hypothesis is a plane; then it is kept and its readings are claimed.
bool PlaneFinder::Consider(DepthView& view, const Hypothesis& hypothesis) {
  DetectedPlane plane;
  const bool fits = !found_.full() && hypothesis.score >= 4 && hypothesis.m.allFinite() &&
                    Refine(view, hypothesis.m, plane.fit) && plane.fit.chi2 < config_.chi2_max;
  const Eigen::Vector3f m = fits ? InverseDepthForm(plane.fit) : hypothesis.m;
  const int marked = Collect(view, m, config_.inlier_sigmas);
  const int kept = KeepLargeParts(view, marked);
  if (fits && Bound(view, kept, plane)) {
    Polish(view, kept, plane);
    (void)found_.push_back(plane);
    Claim(view, plane);
    for (int i = 0; i < view.size(); ++i) {
      barred_[i] |= static_cast<std::uint8_t>(view.use(i) == DepthView::Use::kPlane);
    }
    return true;
  }
  return false;
}

/// Takes the readings of the last hypothesis out of further draws.
void PlaneFinder::Bar(const DepthView& view) {
  for (int i = 0; i < view.size(); ++i) {
    barred_[i] |= static_cast<std::uint8_t>(mark_[i] != 0);
  }
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
      const Eigen::Vector3f m = InverseDepthForm(other.fit);
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
  return shorter_m >= least_m && facing / count >= kMinFacing &&
         area_m2 >= config_.plane_min_fill * (hi[0] - lo[0]) * (hi[1] - lo[1]);
}

/// Marks all readings near the plane and about its rectangle as of a plane: no pipe is made of
/// them.
void PlaneFinder::Claim(DepthView& view, const DetectedPlane& plane) const {
  const double border_m = 0.1;
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
    if (a >= plane.lo_m[0] - border_m && a <= plane.hi_m[0] + border_m &&
        b >= plane.lo_m[1] - border_m && b <= plane.hi_m[1] + border_m) {
      view.set_use(i, DepthView::Use::kPlane);
    }
  }
}

}  // namespace pipewright
