// SPDX-License-Identifier: MIT
#include "tests/bench/faults/command_judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pipewright::bench {
namespace {

constexpr double kSlack_s = 0.04;

}  // namespace

void CommandJudge::Take(const test::SentTwist& sent) {
  Check(0, 1e-3 * sent.v_mmps, 1e-3, sent.stamp);
  Check(1, 1e-3 * sent.omega_mradps, 1e-3, sent.stamp);
}

void CommandJudge::Take(const test::SentJoint& sent) {
  Check(2 + sent.joint, 1e-6 * sent.velocity_uradps, 1e-6, sent.stamp);
}

void CommandJudge::TakeAll(test::DeviceBench& bench) {
  for (const test::SentTwist& sent : bench.twists) {
    Take(sent);
  }
  for (const test::SentJoint& sent : bench.joints) {
    Take(sent);
  }
  bench.twists.clear();
  bench.joints.clear();
}

void CommandJudge::Check(int axis, double u, double unit, Time stamp) {
  ++commands_;
  Axis& a = axes_[static_cast<std::size_t>(axis)];
  const double most = kAccelerationMax[axis] * kSlack_s;
  const double since_s = a.seen ? ToSeconds(stamp - a.stamp) : 0;
  a.credit = a.seen ? std::min(most, a.credit + kAccelerationMax[axis] * since_s) : most;
  const bool reversed = u * a.u < 0;
  const double growth = reversed ? std::abs(u) : std::abs(u) - std::abs(a.u);
  if (std::abs(u) > kSpeedMax[axis] + unit) {
    ++unlawful_;
    why_ = fmt::format("axis {}: {:.6f} is too fast", axis, u);
  } else if (growth > a.credit + unit) {
    ++unlawful_;
    why_ = fmt::format("axis {}: {:.6f} after {:.6f} within {:.1f} ms is too much", axis, u, a.u,
                       1e3 * since_s);
  }
  a.credit = std::max(0.0, a.credit - std::max(0.0, growth));
  a.u = u;
  a.stamp = stamp;
  a.seen = true;
}

}  // namespace pipewright::bench
