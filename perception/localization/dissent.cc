// SPDX-License-Identifier: MIT
#include "perception/localization/dissent.h"

namespace pipewright {
namespace {

/// Standard deviations of the way between two frames that the wheels do not tell: of a base that
/// brakes on a spill.
constexpr double kStill_m = 5e-3;
constexpr double kStill_rad = 0.01;

}  // namespace

void Dissent::Add(const PoseFix& fix, const Vector3d& pose, const FixNoiseConfig& noise) {
  const Mat<3, 3> still =
      Vector3d(kStill_m * kStill_m, kStill_m * kStill_m, kStill_rad * kStill_rad).asDiagonal();
  const bool same =
      count_ > 0 && GainOf(pose + offset_, still, fix, Vector3d::Zero(), noise).within_gate;
  count_ = same ? count_ + 1 : 1;
  offset_ = GainOf(pose, still, fix, Vector3d::Zero(), noise).y;
}

}  // namespace pipewright
