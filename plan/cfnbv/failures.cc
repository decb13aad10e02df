// SPDX-License-Identifier: MIT
#include "plan/cfnbv/failures.h"

#include <algorithm>

namespace pipewright {

Failures::Failures(int workspace_voxels, int tries, double stall_radius_m)
    : tries_(tries),
      stall_radius_m_(stall_radius_m),
      unsettled_(static_cast<std::size_t>(workspace_voxels), 0),
      pathless_(unsettled_.size(), 0),
      ignored_(unsettled_.size(), 0) {}

void Failures::ForgetPathless() { std::fill(pathless_.begin(), pathless_.end(), std::uint8_t{0}); }

void Failures::ForgetAll() {
  ForgetPathless();
  std::fill(unsettled_.begin(), unsettled_.end(), std::uint8_t{0});
  stall_count_ = 0;
}

void Failures::Refresh() {
  for (std::size_t i = 0; i < ignored_.size(); ++i) {
    ignored_[i] = unsettled_[i] >= tries_ || pathless_[i] >= tries_ ? 1 : 0;
  }
}

void Failures::AddStall(const Viewpoint& view) {
  stalls_[stall_count_++ % kStalls] = {view.X_WS.translation(), view.X_WS.linear().col(2)};
}

int Failures::StallsNear(const Viewpoint& view) const {
  constexpr double kSameAxis = 0.8;
  int near = 0;
  for (int i = 0; i < std::min(stall_count_, kStalls); ++i) {
    const double distance_m = (stalls_[i].p_WS - view.X_WS.translation()).norm();
    const double along = stalls_[i].z_WS.dot(view.X_WS.linear().col(2));
    near += distance_m <= stall_radius_m_ && along >= kSameAxis ? 1 : 0;
  }
  return near;
}

}  // namespace pipewright
