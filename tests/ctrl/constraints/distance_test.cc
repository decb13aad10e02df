// SPDX-License-Identifier: MIT
#include "ctrl/constraints/distance.h"

#include <gtest/gtest.h>

#include "platform/robot/kinematics.h"
#include "platform/robot/state_history.h"
#include "tests/ctrl/constraints/random_world.h"

namespace pipewright {
namespace {

using test::MakePipe;
using test::MakePlane;
using test::RandomConfiguration;
using test::RandomDirection;
using test::RandomIn;

const Vector3d kLo{-1, -1, -1};
const Vector3d kHi{1, 1, 1};

/// Checks d' = gradient' J u against the distance one short period later, both ways.
template <typename F>
void ExpectRateMatches(Rng& rng, const F& distance_at) {
  const Configuration q = RandomConfiguration(rng);
  const int body = rng.Index(Kinematics<kArmJoints>::kBodies);
  const Vector3d p_L = RandomIn(rng, 0.2 * kLo, 0.2 * kHi);
  Controls u;
  for (int i = 0; i < kControls; ++i) {
    u(i) = rng.Uniform(-1, 1);
  }
  const auto distance = [&](double dt) -> PointDistance {
    const Kinematics<kArmJoints> k(TracerUf7(), Advance(q, u, dt));
    return distance_at(k.Point(body, p_L));
  };
  const PointDistance now = distance(0);
  if (now.d_m < 0.02 && now.d_m > -0.02) {
    return;  // too near to a kink for central differences
  }
  const Kinematics<kArmJoints> k(TracerUf7(), q);
  const Controls g = k.PointJacobian(body, p_L).transpose() * now.gradient_W;
  constexpr double kStep = 1e-5;
  const double rate = (distance(kStep).d_m - distance(-kStep).d_m) / (2 * kStep);
  EXPECT_NEAR(g.dot(u), rate, 2e-8 + 1e-8 / std::abs(now.d_m));
}

TEST(Distance, RatesAreThoseOfFiniteDifferences) {
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE(i);
    Rng rng(1, i);
    const PlaneEstimate plane =
        MakePlane(1, RandomIn(rng, kLo, kHi), RandomDirection(rng), 1, 0, 0);
    ExpectRateMatches(rng, [&](const Vector3d& p) { return PointToPlane(p, plane); });
    const PipeEstimate pipe =
        MakePipe(1, RandomIn(rng, kLo, kHi), RandomDirection(rng), 0.05, 5, 0, 0);
    ExpectRateMatches(rng, [&](const Vector3d& p) { return PointToPipeAxis(p, pipe, 0).to_axis; });
    PipeEstimate end = pipe;  // reached at its end only
    end.extent_lo_m = end.extent_hi_m = 3;
    ExpectRateMatches(rng,
                      [&](const Vector3d& p) { return PointToPipeAxis(p, end, 0.15).to_axis; });
    PipeEstimate part = pipe;  // beside it or beyond it
    part.extent_lo_m = -0.2;
    part.extent_hi_m = rng.Uniform(-0.2, 0.4);
    ExpectRateMatches(rng,
                      [&](const Vector3d& p) { return PointToPipeAxis(p, part, 0.15).to_axis; });
    const Vector3d point = RandomIn(rng, kLo, kHi);
    ExpectRateMatches(rng, [&](const Vector3d& p) { return PointToPoint(p, point); });
  }
}

TEST(PointToPipeAxis, TakesTheEndBeyondTheInflatedExtent) {
  const PipeEstimate pipe = MakePipe(1, {0, 0, 0}, {0, 0, 1}, 0.05, 0.5, 0, 0);
  const AxisDistance beside = PointToPipeAxis({0.3, 0, 0.6}, pipe, 0.15);
  EXPECT_FALSE(beside.at_end);
  EXPECT_NEAR(beside.to_axis.d_m, 0.3, 1e-15);
  const AxisDistance end = PointToPipeAxis({0.3, 0, 1.05}, pipe, 0.15);
  EXPECT_TRUE(end.at_end);
  EXPECT_NEAR(end.s_m, 0.65, 1e-15);
  EXPECT_NEAR(end.to_axis.d_m, 0.5, 1e-15);
  EXPECT_NEAR(end.to_axis.gradient_W.z(), 0.8, 1e-15);  // holds motion along the axis, too
}

PipeEstimate ShortPipe(Rng& rng) {
  PipeEstimate pipe = MakePipe(1, RandomIn(rng, kLo, kHi), RandomDirection(rng), 0.05, 0, 0, 0);
  pipe.extent_lo_m = -rng.Uniform(0, 0.5);
  pipe.extent_hi_m = rng.Uniform(0, 0.5);
  return pipe;
}

/// To what was seen of a pipe's axis: the least over a fine grid, so not below the truth.
double ToSeen(const Vector3d& t, const PipeEstimate& pipe) {
  double least = 1e9;
  constexpr int kSteps = 1000;
  for (int i = 0; i <= kSteps; ++i) {
    const double s =
        pipe.extent_lo_m + (pipe.extent_hi_m - pipe.extent_lo_m) * i / static_cast<double>(kSteps);
    least = std::min(least, (t - pipe.p_W - s * pipe.l_W).norm());
  }
  return least;
}

TEST(PointToPipeAxis, NeverJumpsAndNeverSaysMoreThanTheDistanceToWhatWasSeen) {
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE(i);
    Rng rng(4, i);
    const PipeEstimate pipe = ShortPipe(rng);
    const Vector3d from = pipe.p_W + RandomIn(rng, kLo, kHi);
    const Vector3d to = pipe.p_W + RandomIn(rng, kLo, kHi);
    constexpr int kSteps = 400;
    AxisDistance last = PointToPipeAxis(from, pipe, 0.15);
    for (int k = 1; k <= kSteps; ++k) {
      const Vector3d t = from + (to - from) * k / kSteps;
      const double step = (to - from).norm() / kSteps;
      const AxisDistance now = PointToPipeAxis(t, pipe, 0.15);
      EXPECT_LE(std::abs(now.to_axis.d_m - last.to_axis.d_m), step + 1e-12);
      const double nearer = std::min(now.to_axis.d_m, last.to_axis.d_m);
      EXPECT_LE((now.to_axis.gradient_W - last.to_axis.gradient_W).norm(),
                1.05 * step / nearer + 1e-12);
      EXPECT_LE(now.to_axis.d_m, ToSeen(t, pipe) + 1e-12);
      last = now;
    }
  }
}

/// The rule that the rows state, -g'v <= eta (d - d_safe), on a point that is driven at the pipe
/// from everywhere, along its axis among others: the distance to what was seen holds.
TEST(PointToPipeAxis, ItsRateBoundKeepsAPointAwayFromEndsAndSides) {
  constexpr double kSafe_m = 0.1;
  constexpr double kEta_1ps = 1;
  constexpr double kPeriod_s = 0.01;
  int close = 0;
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE(i);
    Rng rng(5, i);
    const PipeEstimate pipe = ShortPipe(rng);
    Vector3d t = pipe.p_W + 1.2 * pipe.l_W;  // beyond the end
    if (i % 3 > 0) {
      t += (i % 3 == 1 ? 0.02 : 0.5) * RandomDirection(rng);
    }
    const Vector3d goal = pipe.p_W + rng.Uniform(-0.3, 0.3) * pipe.l_W;
    for (int k = 0; k < 800; ++k) {
      Vector3d v = 2 * (goal - t) + 0.1 * RandomDirection(rng);
      const PointDistance d = PointToPipeAxis(t, pipe, 0.15).to_axis;
      const double limit = -kEta_1ps * (d.d_m - kSafe_m);
      v += std::max(0.0, limit - d.gradient_W.dot(v)) * d.gradient_W;
      t += kPeriod_s * v;
      ASSERT_GE(ToSeen(t, pipe), kSafe_m - 1e-9);
      close += PointToPipeAxis(t, pipe, 0.15).to_axis.d_m < 1.05 * kSafe_m ? 1 : 0;
    }
  }
  EXPECT_GT(close, 10000);
}

TEST(PointToPoint, HasNoDirectionWhereItHasNone) {
  EXPECT_TRUE(PointToPoint(kLo, kLo).gradient_W.isZero(0));
}

/// Least distance over a fine grid of both segments: never below the truth.
double BruteForce(const Vector3d& a0, const Vector3d& a1, const Vector3d& b0, const Vector3d& b1) {
  double least = 1e9;
  constexpr int kSteps = 200;
  for (int i = 0; i <= kSteps; ++i) {
    const Vector3d p = a0 + (a1 - a0) * i / kSteps;
    const Vector3d d = b1 - b0;
    const double t =
        d.squaredNorm() > 0 ? std::clamp(d.dot(p - b0) / d.squaredNorm(), 0.0, 1.0) : 0.0;
    least = std::min(least, (p - b0 - t * d).norm());
  }
  return least;
}

TEST(SegmentToSegment, IsTheLeastOverAllPoints) {
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE(i);
    Rng rng(2, i);
    const Vector3d a0 = RandomIn(rng, kLo, kHi);
    const Vector3d b0 = RandomIn(rng, kLo, kHi);
    Vector3d a1 = RandomIn(rng, kLo, kHi);
    Vector3d b1 = RandomIn(rng, kLo, kHi);
    if (i % 5 == 1) {
      b1 = b0 + 0.7 * (a1 - a0);  // parallel
    } else if (i % 5 == 2) {
      a1 = a0;  // a point
    } else if (i % 5 == 3) {
      b1 = b0;
    }
    const SegmentPair pair = SegmentToSegment(a0, a1, b0, b1);
    EXPECT_LE(pair.d_m, BruteForce(a0, a1, b0, b1) + 1e-12);
    EXPECT_NEAR(pair.d_m, (a0 + pair.s * (a1 - a0) - b0 - pair.t * (b1 - b0)).norm(), 1e-12);
    EXPECT_NEAR(pair.direction_W.norm(), 1, 1e-12);
  }
}

TEST(SegmentToBox, IsTheLeastOverAllPoints) {
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE(i);
    Rng rng(3, i);
    const Vector3d a = RandomIn(rng, kLo, kHi);
    Vector3d b = RandomIn(rng, kLo, kHi);
    if (i % 4 == 1) {
      b.x() = a.x();  // along a face
    } else if (i % 4 == 2) {
      b = a;
    }
    Isometry3d X_WG = Isometry3d::Identity();
    if (i % 4 != 1) {
      X_WG.linear() = Eigen::AngleAxisd(rng.Uniform(0, 3), RandomDirection(rng)).toRotationMatrix();
    }
    X_WG.translation() = RandomIn(rng, 0.5 * kLo, 0.5 * kHi);
    const Vector3d half{0.35, 0.25, 0.06};
    const BoxPair pair = SegmentToBox(a, b, X_WG, half);
    double least = 1e9;
    for (int k = 0; k <= 500; ++k) {
      const Vector3d p_G = X_WG.inverse() * Vector3d(a + (b - a) * k / 500);
      least = std::min(least, (p_G - p_G.cwiseMax(-half).cwiseMin(half)).norm());
    }
    EXPECT_LE((pair.p_WSegment - pair.p_WBox).norm(), least + 1e-12);
    const Vector3d on_box = X_WG.inverse() * pair.p_WBox;
    EXPECT_TRUE((on_box.cwiseAbs() - half).maxCoeff() < 1e-12);
  }
}

}  // namespace
}  // namespace pipewright
