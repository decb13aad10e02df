// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "perception/primitives/pipe_finder.h"
#include "perception/primitives/pipe_rays.h"

namespace pipewright {
namespace {

constexpr int kRounds = 2;
constexpr float kMinFacing = 0.25F;  // cosine to the view: more is not lost to grazing
constexpr double kRangeSigmas = 4;
constexpr float kReach_m = 3;
constexpr int kBorder = 8;           // pixels
constexpr float kGoesOnSigmas = 15;  // off the pipe: farther, it is behind or before it
constexpr int kStraySupport = 5;     // of 9 pixels: with more about it, it is of the pipe
constexpr double kClaim_m = 0.01;    // of other pipes, as in Claim()

}  // namespace

/// Whether a reading of this point might have been taken for another primitive's: then those that
/// were not are a choice by their noise.
/// @param sigma_m  noise of a reading of it along its ray, the most across any surface
bool PipeFinder::NearAnother(const Vector3d& p_SQ, double sigma_m) const {
  const double gate = config_.inlier_sigmas;
  const double clear = config_.plane_clear_sigmas + gate;
  const double clear_m = 2 * config_.plane_clear_m;
  for (const DetectedPlane& plane : planes_) {
    const double off_m = std::abs(plane.fit.n_S.dot(p_SQ) - plane.fit.d_m);
    if (off_m < std::max(clear_m, clear * sigma_m) &&
        Near(plane, p_SQ, config_.noise, clear, clear_m)) {
      return true;
    }
  }
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

/// Tells for each pixel whether its reading is within the gate of the pipe where that faces the
/// camera, or off it by so little that its surface may go on from it. A box about those within.
PixelBox PipeFinder::MarkAlongRays(const DepthView& view, const DetectedPipe& pipe) {
  PixelBox box{view.height(), -1, view.width(), -1};
  std::fill_n(side_.begin(), view.size(), Side::kNone);
  const auto gate = static_cast<float>(config_.inlier_sigmas);
  PipeRays(pipe.fit).ForMeeting(view, [&](int i, const PipeRays::Entry& entry) {
    const Floats w = 1 / entry.z_m;
    const Floats sigmas =
        Absolute(w * (1 - w / view.four_inverse_z(i))) / SigmaInverse(w, config_.noise);
    const Masks about = entry.meets & (entry.cosine2 >= kMinFacing * kMinFacing) &
                        (Absolute(entry.s_m) <= kReach_m) & (sigmas < kGoesOnSigmas);
    Store(entry.z_m, &z_on_pipe_m_[i]);
    Store(entry.s_m, &along_pipe_m_[i]);
    for (int lane = 0; lane < kLanes && Any(about); ++lane) {
      const int j = i + lane;
      if (about[lane] != 0 && (sigmas[lane] > gate || reading_of_[j] < 0)) {
        side_[j] = Side::kGoesOn;
      } else if (about[lane] != 0) {
        side_[j] = Side::kOnPipe;
        const int row = j / view.width();
        const int column = j % view.width();
        box = {std::min(box.row_lo, row), std::max(box.row_hi, row),
               std::min(box.column_lo, column), std::max(box.column_hi, column)};
      }
    }
  });
  return {std::max(0, box.row_lo - kBorder), std::min(view.height() - 1, box.row_hi + kBorder),
          std::max(0, box.column_lo - kBorder),
          std::min(view.width() - 1, box.column_hi + kBorder)};
}

/// Measures how many pixels each pixel is from a surface that goes on from the pipe and is none of
/// it.
void PipeFinder::MeasureFromOthers(const DepthView& view, const PixelBox& box) {
  const int width = view.width();
  const auto support = [&](int row, int column) {
    int on = 0;
    for (int r = std::max(0, row - 1); r <= std::min(view.height() - 1, row + 1); ++r) {
      for (int c = std::max(0, column - 1); c <= std::min(width - 1, column + 1); ++c) {
        on += side_[r * width + c] == Side::kOnPipe;
      }
    }
    return on;
  };
  for (int row = box.row_lo; row <= box.row_hi; ++row) {
    for (int column = box.column_lo; column <= box.column_hi; ++column) {
      const int i = row * width + column;
      const bool other = side_[i] == Side::kGoesOn && support(row, column) <= kStraySupport;
      from_other_[i] = other ? 0 : 255;
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
  MeasureFromOthers(view, box);
  const double range_m = config_.pipe_range_m;
  const double nearest = 1 / range_m + kRangeSigmas * config_.noise.SigmaInverse(1 / range_m);
  int agree = 0;
  for (int row = box.row_lo; row <= box.row_hi; ++row) {
    for (int i = row * view.width() + box.column_lo; i <= row * view.width() + box.column_hi; ++i) {
      const double s_m = along_pipe_m_[i];
      const double z_m = z_on_pipe_m_[i];
      if (side_[i] != Side::kOnPipe || s_m < pipe.lo_m || s_m > pipe.hi_m || z_m * nearest > 1) {
        continue;
      }
      const Vector3d p_SQ = z_m * Vector3d(view.x(i), view.y(i), 1);
      const double sigma_z = z_m * config_.noise.SigmaInverse(1 / z_m);
      const double reach = 1 + config_.inlier_sigmas * sigma_z * static_cast<double>(view.focal());
      if (from_other_[i] > reach && !NearAnother(p_SQ, sigma_z * p_SQ.norm())) {
        agree_[agree++] = i;
      }
    }
  }
  if (step == 0) {
    step = 1 + agree / (kMaxPoints * 3 / 4);
  }
  int count = 0;
  for (int k = 0; k < agree && count < kMaxPoints; ++k) {
    if (agree_[k] % step == 0) {
      point_[count++] = view.p_S(agree_[k]);
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
