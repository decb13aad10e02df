// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "hil/cli/run_figures.h"

namespace pipewright::hil {

/// Adds one control cycle after the other to the figures that only the emulator can know: how far
/// the pose is from the truth, whether a joint passed its limit, how long coverage took.
///
/// A state is of its own stamp, some milliseconds before the cycle. Its pose is compared with the
/// truth of that instant, between those of the cycles about it: a base that turns at 1 rad/s is
/// 0.5 degrees on by the time the cycle comes.
class TruthWatch {
 public:
  void Add(const ControlReport& report, const Emulator& emulator, RunFigures& figures);

 private:
  struct Moment {
    Time stamp{};
    BasePose base;
  };

  BasePose At(Time stamp) const;

  static constexpr int kMoments = 8;
  std::array<Moment, kMoments> moments_{};
  int newest_ = 0;
};

}  // namespace pipewright::hil
