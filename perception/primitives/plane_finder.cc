// SPDX-License-Identifier: MIT
#include "perception/primitives/plane_finder.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace pipewright {
namespace {

constexpr int kAttempts = 12;  // hypotheses refined a frame
constexpr int kRounds = 3;
constexpr int kHintRounds = 1;
constexpr int kFitPoints =
    5000;                     // as good as all for a gate: what it errs by, the fit errs by 3 % of
constexpr int kMinPart = 20;  // pixels: smaller islands of a plane do not count
constexpr double kPartShare = 0.05;

}  // namespace

void PlaneFinder::Find(DepthView& view, std::span<const PlaneFit> hints) {
  found_.clear();
  Unbar(view);
  Search(view, hints);
  // Now that all planes are known: each without what is near another.
  Unbar(view);
  int kept = 0;
  for (DetectedPlane& plane : found_) {
    if (Polish(view, plane)) {
      found_[kept++] = plane;
    }
  }
  while (found_.size() > kept) {
    found_.pop_back();
  }
}

/// Bars what is out of range, and nothing else.
void PlaneFinder::Unbar(const DepthView& view) {
  const auto range_m = static_cast<float>(config_.plane_range_m);
  for (int i = 0; i < view.size(); ++i) {
    barred_[i] = static_cast<std::uint8_t>(!(view.inverse_z(i) * range_m >= 1));
  }
}

void PlaneFinder::Search(DepthView& view, std::span<const PlaneFit> hints) {
  Sample(view);
  for (const PlaneFit& hint : hints) {
    if (hint.d_m < 0) {
      const Eigen::Vector3f m = InverseDepth(hint);
      Consider(view, {m, Score(m)}, kHintRounds);
    }
  }
  for (int attempt = 0; attempt < kAttempts && !found_.full(); ++attempt) {
    Sample(view);
    const Hypothesis best = Draw(view);
    if (best.score < 8) {
      return;
    }
    if (!Consider(view, best, kRounds)) {
      Bar(view);
    }
  }
}

/// Evenly spaced readings among those that are free and not barred.
void PlaneFinder::Sample(const DepthView& view) {
  int free = 0;
  for (int i = 0; i < view.size(); ++i) {
    free_[free] = i;
    free += barred_[i] == 0;
  }
  samples_ = std::min(free, kMaxSamples);
  for (int k = 0; k < samples_; ++k) {
    const int i = free_[static_cast<long>(k) * free / samples_];
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
  // Where a plane crosses the range's end, readings are kept by their noise. Ask the plane, not
  // them.
  const double range_m = config_.plane_range_m;
  const double end_sigma = config_.noise.SigmaInverse(1 / range_m);
  const auto nearest = static_cast<float>(1 / range_m + (config_.inlier_sigmas + 1) * end_sigma);
  const int size = view.size();
  for (int i = 0; i < size; ++i) {
    const float expected = m.x() * view.x(i) + m.y() * view.y(i) + m.z();
    // As far as the fit sees it: what is symmetric in depth is not in inverse depth.
    const float residual = expected * (1 - expected / view.inverse_z(i));
    int on = barred_[i] == 0 ? 1 : 0;  // no branches: four readings at a time
    on &= expected > nearest ? 1 : 0;
    on &= std::abs(residual) * view.inverse_sigma(i) < limit ? 1 : 0;
    mark_[i] = static_cast<std::uint8_t>(on);
  }
  std::fill_n(mark_.begin() + size, kLanes, std::uint8_t{0});
  int count = 0;
  for (int i = 0; i < size; ++i) {
    inlier_[count] = i;
    count += mark_[i];
  }
  return count;
}

/// Collects and fits in turn; the fits are to a part of the readings, for Polish() takes them all.
bool PlaneFinder::Refine(const DepthView& view, Eigen::Vector3f m, int rounds, PlaneFit& fit) {
  const int least = static_cast<int>(config_.plane_min_share * view.size());
  for (int k = 0; k < rounds; ++k) {
    int count = Collect(view, m, config_.inlier_sigmas);
    if (k > 0) {
      count = KeepLargeParts(view, count);
    }
    if (count < least) {
      return false;
    }
    const int step = 1 + count / kFitPoints;
    int used = 0;
    for (int i = 0; i < count; i += step) {
      point_[used++] = view.p_S(inlier_[i]);
    }
    const auto fitted = FitPlane({point_.data(), static_cast<std::size_t>(used)}, config_.noise);
    if (!fitted.ok()) {
      return false;
    }
    fit = *fitted;
    m = InverseDepth(fit);
  }
  return true;
}

/// Drops islands of marked pixels that are too small; marks what stays with 3 and packs it. An
/// island is made of runs, stretches of a row, that touch runs of the row before.
int PlaneFinder::KeepLargeParts(const DepthView& view, int count) {
  const int least = std::max(kMinPart, static_cast<int>(kPartShare * count));
  const int width = view.width();
  const auto root = [this](int r) {
    while (run_[r].parent != r) {
      r = run_[r].parent = run_[run_[r].parent].parent;
    }
    return r;
  };
  int runs = 0;
  int before = 0;  // the first run of the row before that can still touch
  for (int k = 0; k < count;) {
    const int begin = inlier_[k];
    const int row_end = (begin / width + 1) * width;
    int end = begin;  // one past
    while (k < count && inlier_[k] == end && end < row_end) {
      ++end;
      ++k;
    }
    run_[runs] = {begin, end, runs, end - begin};
    while (before < runs && run_[before].end + width < begin) {
      ++before;
    }
    // Those that touch it, corners included; none where they wrap about the image's sides.
    const int above_row = (begin / width - 1) * width;
    for (int r = before; r < runs && run_[r].begin + width <= end; ++r) {
      if (run_[r].begin < above_row || run_[r].begin >= above_row + width) {
        continue;
      }
      const int one = root(r);
      const int other = root(runs);
      if (one != other) {
        run_[other].parent = one;
        run_[one].size += run_[other].size;
      }
    }
    ++runs;
  }
  int kept = 0;
  for (int r = 0; r < runs; ++r) {
    const bool large = run_[root(r)].size >= least;
    for (int i = run_[r].begin; i < run_[r].end; ++i) {
      mark_[i] = large ? 3 : 0;
      inlier_[kept] = i;
      kept += large;
    }
  }
  return kept;
}

/// Whether a hypothesis is a plane; then it is kept and its readings are claimed.
bool PlaneFinder::Consider(DepthView& view, const Hypothesis& hypothesis, int rounds) {
  DetectedPlane plane;
  const bool fits = !found_.full() && hypothesis.score >= 4 && hypothesis.m.allFinite() &&
                    Refine(view, hypothesis.m, rounds, plane.fit) &&
                    plane.fit.chi2 < config_.chi2_max;
  const Eigen::Vector3f m = fits ? InverseDepth(plane.fit) : hypothesis.m;
  const int marked = Collect(view, m, config_.inlier_sigmas);
  const int kept = KeepLargeParts(view, marked);
  if (fits && Bound(view, kept, plane)) {
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

}  // namespace pipewright
