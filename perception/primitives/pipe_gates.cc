// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/primitives/pipe_finder.h"
#include "perception/primitives/pipe_rays.h"

namespace pipewright {
namespace {

constexpr int kRefinements = 3;
constexpr double kBin_m = 0.02;  // of the axis
constexpr int kBins = 150;       // 3 m, p in the middle
constexpr int kMinInBin = 2;
constexpr int kArcBins = 36;
constexpr double kRefineFactor = 1.3;  // radius limits while refining
constexpr double kMaxAxisSigma_rad = 0.15;
constexpr float kBehind_m = 0.03F;  // a reading this far behind a pipe is seen through it
constexpr float kBehindSigmas = 4;  // and this much more
constexpr double kCore = 0.8;       // share of the radius within which rays are asked
constexpr float kClaim_m = 0.01F;

int BinOf(double s_m) {
  return std::clamp(static_cast<int>(std::floor(s_m / kBin_m)) + kBins / 2, 0, kBins - 1);
}

}  // namespace

/// Calls use(k, s) for the readings that agree with a pipe and are not barred.
template <typename Use>
void PipeFinder::ForAgreeing(const CylinderFit& pipe, const Use& use) const {
  const PipeAxis axis(pipe);
  const auto sigmas = static_cast<float>(config_.inlier_sigmas);
  for (int k = 0; k < reading_.size(); k += kLanes) {
    Floats s_m;
    const Masks agree = reading_.Agree(k, axis, sigmas, s_m);
    for (int lane = 0; lane < kLanes && Any(agree); ++lane) {
      if (agree[lane] != 0 && barred_[k + lane] == 0) {
        use(k + lane, s_m[lane]);
      }
    }
  }
}

/// The readings that agree with a pipe, of the stretch about the fullest part of its axis; its
/// ends.
int PipeFinder::Collect(const CylinderFit& pipe, DetectedPipe& bounds) {
  std::array<int, kBins> histogram{};
  int agree = 0;
  ForAgreeing(pipe, [&](int k, float s_m) {
    ++histogram[BinOf(s_m)];
    agree_[agree] = k;
    along_m_[agree++] = s_m;
  });
  const int fullest =
      static_cast<int>(std::max_element(histogram.begin(), histogram.end()) - histogram.begin());
  const int gap = static_cast<int>(config_.pipe_max_gap_m / kBin_m);
  int first = fullest;
  int last = fullest;
  for (int bin = fullest; bin >= 0 && first - bin <= gap; --bin) {
    first = histogram[bin] >= kMinInBin ? bin : first;
  }
  for (int bin = fullest; bin < kBins && bin - last <= gap; ++bin) {
    last = histogram[bin] >= kMinInBin ? bin : last;
  }
  bounds.fit = pipe;
  bounds.lo_m = 1e9;
  bounds.hi_m = -1e9;
  const int step = 1 + agree / kRoughPoints;
  int passed = 0;
  int count = 0;
  for (int k = 0; k < agree; ++k) {
    const double along_m = along_m_[k];
    const int bin = BinOf(along_m);
    if (bin < first || bin > last) {
      continue;
    }
    bounds.lo_m = std::min(bounds.lo_m, along_m);
    bounds.hi_m = std::max(bounds.hi_m, along_m);
    if (passed++ % step == 0) {
      point_[count++] = reading_.p_S(agree_[k]);
    }
  }
  return count;
}

bool PipeFinder::Refine(const Hypothesis& hypothesis, DetectedPipe& pipe) {
  pipe.fit = hypothesis.pipe;
  for (int k = 0; k < kRefinements; ++k) {
    const int count = Collect(pipe.fit, pipe);
    if (count < config_.pipe_min_points) {
      return false;
    }
    const auto fitted =
        FitCylinder({point_.data(), static_cast<std::size_t>(count)}, pipe.fit, config_.noise);
    if (!fitted.ok() || fitted->radius_m > config_.pipe_radius_max_m * kRefineFactor ||
        fitted->radius_m < config_.pipe_radius_min_m / kRefineFactor) {
      return false;
    }
    pipe.fit = *fitted;
  }
  return true;
}

/// Angle about the axis that the inliers cover, in steps of 10 degrees; 0 unless it reaches to both
/// sides of where the axis faces the camera: a strip cut off by the image's border can be anything.
double PipeFinder::Arc(const CylinderFit& pipe, int count) const {
  const Vector3d e1 = -(pipe.p_S - pipe.l_S.dot(pipe.p_S) * pipe.l_S).normalized();
  const Vector3d e2 = pipe.l_S.cross(e1);
  std::array<int, kArcBins> histogram{};
  for (int k = 0; k < count; ++k) {
    const Vector3d w = point_[k].cast<double>() - pipe.p_S;
    const double turns = std::atan2(e2.dot(w), e1.dot(w)) / (2 * std::numbers::pi);
    const int bin = static_cast<int>(std::floor((turns + 0.5) * kArcBins));
    ++histogram[std::clamp(bin, 0, kArcBins - 1)];
  }
  const auto filled = [](const int* begin, const int* end) {
    return static_cast<double>(
               std::count_if(begin, end, [](int readings) { return readings >= kMinInBin; })) *
           2 * std::numbers::pi / kArcBins;
  };
  const int* middle = histogram.data() + kArcBins / 2;
  const double left = filled(histogram.data(), middle);
  const double right = filled(middle, histogram.data() + kArcBins);
  return std::min(left, right) < config_.pipe_min_side_arc_rad ? 0 : left + right;
}

/// Whether few readings lie behind a pipe on rays that should have ended on it.
bool PipeFinder::HidesWhatIsBehind(const DepthView& view, const DetectedPipe& pipe) const {
  CylinderFit core = pipe.fit;
  core.radius_m *= kCore;
  const auto lo_m = static_cast<float>(pipe.lo_m);
  const auto hi_m = static_cast<float>(pipe.hi_m);
  Masks hit{};
  Masks through{};
  PipeRays(core).ForMeeting(view, [&](int i, const PipeRays::Entry& entry) {
    const Masks asked = entry.meets & (entry.s_m >= lo_m) & (entry.s_m <= hi_m);
    const Floats z2 = entry.z_m * entry.z_m;
    const Floats noise_m = kBehindSigmas * z2 * SigmaInverse(1 / entry.z_m, config_.noise);
    hit -= asked;
    through -= asked & (1 / view.four_inverse_z(i) > entry.z_m + kBehind_m + noise_m);
  });
  return Sum(through) <= config_.pipe_see_through_max * Sum(hit);
}

bool PipeFinder::IsPipe(const DepthView& view, const DetectedPipe& pipe, int count) const {
  const CylinderFit& fit = pipe.fit;
  const double length_m = pipe.hi_m - pipe.lo_m;
  const double axis_rad = std::sqrt(fit.covariance.block<3, 3>(3, 3).trace());
  const bool plausible =
      count >= config_.pipe_min_points && fit.radius_m >= config_.pipe_radius_min_m &&
      fit.radius_m <= config_.pipe_radius_max_m && fit.chi2 < config_.chi2_max &&
      length_m >= std::max(config_.pipe_min_length_m, 1.5 * fit.radius_m) &&
      std::sqrt(fit.covariance(6, 6)) <= config_.pipe_radius_sigma_max * fit.radius_m &&
      axis_rad <= kMaxAxisSigma_rad && Arc(fit, count) >= config_.pipe_min_arc_rad;
  if (!plausible) {
    return false;
  }
  const auto plane = FitPlane({point_.data(), static_cast<std::size_t>(count)}, config_.noise);
  const bool flat = plane.ok() && plane->chi2 < config_.pipe_min_roundness * fit.chi2;
  return !flat && HidesWhatIsBehind(view, pipe);
}

/// Whether a hypothesis is a pipe; then it is kept and its readings are claimed.
bool PipeFinder::Consider(DepthView& view, const Hypothesis& hypothesis) {
  DetectedPipe pipe;
  if (!found_.full() && Refine(hypothesis, pipe)) {
    DetectedPipe bounds;
    Collect(pipe.fit, bounds);
    pipe.lo_m = bounds.lo_m;
    pipe.hi_m = bounds.hi_m;
    if (Polish(view, pipe) && IsPipe(view, pipe, pipe.fit.count)) {
      (void)found_.push_back(pipe);
      Claim(view, pipe);
      return true;
    }
  }
  return false;
}

/// Takes a reading out of further draws.
void PipeFinder::Take(int k) {
  barred_[k] = 1;
  reading_of_[pixel_[k]] = -1;
}

void PipeFinder::Bar(const CylinderFit& pipe) {
  ForAgreeing(pipe, [this](int k, float /*s_m*/) { Take(k); });
}

void PipeFinder::Claim(DepthView& view, const DetectedPipe& pipe) {
  const PipeAxis axis(pipe.fit);
  const auto lo_m = static_cast<float>(pipe.lo_m - kBin_m);
  const auto hi_m = static_cast<float>(pipe.hi_m + kBin_m);
  const auto sigmas = static_cast<float>(config_.inlier_sigmas);
  for (int k = 0; k < reading_.size(); k += kLanes) {
    const Masks near = reading_.Near(k, axis, lo_m, hi_m, sigmas, kClaim_m);
    for (int lane = 0; lane < kLanes && Any(near); ++lane) {
      if (near[lane] != 0) {
        Take(k + lane);
        view.set_use(pixel_[k + lane], DepthView::Use::kPipe);
      }
    }
  }
}

}  // namespace pipewright
