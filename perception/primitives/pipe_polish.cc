// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "perception/primitives/pipe_finder.h"

namespace pipewright {
namespace {

constexpr int kRounds = 2;
constexpr double kMinFacing = 0.25;  // cosine to the view: more is not lost to grazing
constexpr double kRangeSigmas = 4;
constexpr double kReach_m = 3;
constexpr int kBorder = 8;            // pixels
constexpr double kGoesOnSigmas = 15;  // off the pipe: farther, it is behind or before it
constexpr int kStraySupport = 5;      // of 9 pixels: with more about it, it is of the pipe
constexpr double kClaim_m = 0.01;     // of other pipes, as in Claim()

}  // namespace

/// Whether a reading of this point might have been taken for another primitive's: then those that
/// were not are a choice by their noise.
bool PipeFinder::NearAnother(const Vector3d& p_SQ) const {
  const double gate = config_.inlier_sigmas;
  const double clear = config_.plane_clear_sigmas + gate;
  for (const DetectedPlane& plane : planes_) {
    if (Near(plane, p_SQ, config_.noise, clear, 2 * config_.plane_clear_m)) {
      return true;
    }
  }
  const double sigma_m = SurfaceSigma(p_SQ, p_SQ.normalized(), config_.noise);
  for (const DetectedPipe& pipe : found_) {
    const Vector3d w = p_SQ - pipe.fit.p_S;
    const double s_m = pipe.fit.l_S.dot(w);
    const double rho_m = std::sqrt(std::max(0.0, w.squaredNorm() - s_m * s_m));
    if (std::abs(rho_m - pipe.fit.radius_m) < 2 * gate * sigma_m + kClaim_m &&
        s_m > pipe.lo_m - kClaim_m && s_m < pipe.hi_m + kClaim_m) {
      return true;
    }
  }
  return false;
}

/// Where the ray of a pixel meets a pipe that has no ends and faces the camera, and how far its
/// reading is from there, in sigmas.
struct PipeFinder::Meeting {
  double z_m;
  double sigmas;
};
std::optional<PipeFinder::Meeting> PipeFinder::Meet(const DepthView& view, const CylinderFit& pipe,
                                                    int i) const {
  const Vector3d ray(view.x(i), view.y(i), 1);
  const std::optional<double> z_m = DepthOfPipe(ray, pipe, -kReach_m, kReach_m);
  if (!z_m) {
    return std::nullopt;
  }
  const Vector3d from = *z_m * ray - pipe.p_S;
  const Vector3d g = (from - pipe.l_S.dot(from) * pipe.l_S) / pipe.radius_m;
  if (-g.dot(ray) < kMinFacing * std::sqrt(ray.squaredNorm())) {
    return std::nullopt;
  }
  const double w = 1 / *z_m;
  return Meeting{
      *z_m, w * (1 - w / static_cast<double>(view.inverse_z(i))) / config_.noise.SigmaInverse(w)};
}

/// Marks the pixels within the gate of the pipe; a box that holds them and a little more.
PixelBox PipeFinder::MarkAlongRays(const DepthView& view, const DetectedPipe& pipe) {
  PixelBox box{view.height(), -1, view.width(), -1};
  std::fill_n(on_pipe_.begin(), view.size(), std::uint8_t{0});
  for (int k = 0; k < readings_; ++k) {
    const int i = reading_[k].pixel;
    const std::optional<Meeting> meeting = Meet(view, pipe.fit, i);
    if (barred_[k] != 0 || !meeting || std::abs(meeting->sigmas) > config_.inlier_sigmas) {
      continue;
    }
    on_pipe_[i] = 1;
    const int row = i / view.width();
    const int column = i % view.width();
    box = {std::min(box.row_lo, row - kBorder), std::max(box.row_hi, row + kBorder),
           std::min(box.column_lo, column - kBorder), std::max(box.column_hi, column + kBorder)};
  }
  return {std::max(0, box.row_lo), std::min(view.height() - 1, box.row_hi),
          std::max(0, box.column_lo), std::min(view.width() - 1, box.column_hi)};
}

/// Measures how many pixels each pixel is from a surface that goes on from the pipe and is none of
/// it.
void PipeFinder::MeasureFromOthers(const DepthView& view, const DetectedPipe& pipe,
                                   const PixelBox& box) {
  const int width = view.width();
  const auto support = [&](int row, int column) {
    int on = 0;
    for (int r = std::max(0, row - 1); r <= std::min(view.height() - 1, row + 1); ++r) {
      for (int c = std::max(0, column - 1); c <= std::min(width - 1, column + 1); ++c) {
        on += on_pipe_[r * width + c];
      }
    }
    return on;
  };
  for (int row = box.row_lo; row <= box.row_hi; ++row) {
    for (int column = box.column_lo; column <= box.column_hi; ++column) {
      const int i = row * width + column;
      from_other_[i] = 255;
      if (view.seen(i) && on_pipe_[i] == 0 && support(row, column) <= kStraySupport) {
        const std::optional<Meeting> meeting = Meet(view, pipe.fit, i);
        from_other_[i] = meeting && std::abs(meeting->sigmas) < kGoesOnSigmas ? 0 : 255;
      }
    }
  }
  SweepDistances(from_other_, width, box);
}

/// The readings within their noise of the depth at which their rays meet the pipe; of more than
/// there is room for each step-th of the view, which the first call of a pipe (step 0) sets. What
/// is asked is asked of the pipe and of whole neighbourhoods, not of the single reading, so that
/// nothing is chosen by its noise; the cut at the gate is symmetric.
int PipeFinder::CollectAlongRays(const DepthView& view, const DetectedPipe& pipe, int& step) {
  const PixelBox box = MarkAlongRays(view, pipe);
  MeasureFromOthers(view, pipe, box);
  const double range_m = config_.pipe_range_m;
  const double nearest = 1 / range_m + kRangeSigmas * config_.noise.SigmaInverse(1 / range_m);
  int agree = 0;
  for (int k = 0; k < readings_; ++k) {
    const int i = reading_[k].pixel;
    if (on_pipe_[i] == 0) {
      continue;
    }
    const Vector3d ray(view.x(i), view.y(i), 1);
    const std::optional<double> z_m = DepthOfPipe(ray, pipe.fit, pipe.lo_m, pipe.hi_m);
    if (!z_m || 1 / *z_m < nearest) {
      continue;
    }
    const double sigma_z = *z_m * config_.noise.SigmaInverse(1 / *z_m);
    const double reach = 1 + config_.inlier_sigmas * sigma_z * static_cast<double>(view.focal());
    if (from_other_[i] > reach && !NearAnother(*z_m * ray)) {
      agree_[agree++] = k;
    }
  }
  if (step == 0) {
    step = 1 + agree / (kMaxPoints * 3 / 4);
  }
  int count = 0;
  for (int k = 0; k < agree && count < kMaxPoints; ++k) {
    if (agree_[k] % step == 0) {
      point_[count++] = reading_[agree_[k]].p_S;
    }
  }
  return count;
}

/// The fit to all readings along rays, and no others; the ends stay at their places. All rounds
/// take the same readings, gate aside: KeptInformation() is of gates that have followed their fit.
bool PipeFinder::Polish(const DepthView& view, DetectedPipe& pipe) {
  int step = 0;
  for (int round = 0; round < kRounds; ++round) {
    const int count = CollectAlongRays(view, pipe, step);
    if (count < config_.pipe_min_points) {
      return false;
    }
    const auto fitted = FitCylinderAlongRays({point_.data(), static_cast<std::size_t>(count)},
                                             pipe.fit, config_.noise, {config_.inlier_sigmas});
    if (!fitted.ok()) {
      return false;
    }
    const Vector3d p_S = pipe.fit.p_S;
    pipe.fit = *fitted;
    const double moved_m = pipe.fit.l_S.dot(pipe.fit.p_S - p_S);
    pipe.lo_m -= moved_m;
    pipe.hi_m -= moved_m;
  }
  return true;
}

}  // namespace pipewright
