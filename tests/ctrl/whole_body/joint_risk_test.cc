// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <memory>

#include "ctrl/whole_body/chance_qp.h"
#include "platform/core/rng.h"
#include "tests/ctrl/constraints/random_world.h"

namespace pipewright {
namespace {

constexpr int kPlanes = 3;
constexpr double kTilt_rad = 0.1;
constexpr double kShift_m = 0.02;
constexpr double kSafe_m = 0.1;

/// A corner of three planes that a point is pulled into: every row is active at the optimum.
struct Corner {
  explicit Corner(Rng& rng) {
    Mat<3, kControls> J;
    for (int i = 0; i < kControls; ++i) {
      J.col(i) = test::RandomDirection(rng);
    }
    t = test::RandomIn(rng, {-1, -1, -1}, {1, 1, 1});
    cost.H.diagonal().setConstant(0.2);
    cost.g.setZero();
    set.lb.setConstant(-3);
    set.ub.setConstant(3);
    for (int k = 0; k < kPlanes; ++k) {
      const Vector3d n = -Vector3d::Unit(k);
      const Vector3d foot = t - rng.Uniform(0.25, 0.4) * n;
      planes[k] = test::MakePlane(1, foot + 0.3 * n.unitOrthogonal(), n, 1, kTilt_rad, kShift_m);
      ChanceRow row;
      row.J = J;
      row.a = -(J.transpose() * n);
      row.b = row.limit = PointToPlane(t, planes[k]).d_m - kSafe_m;
      row.cone = PlaneCone(planes[k], t, 1);
      row.key = k;
      EXPECT_TRUE(set.chance.push_back(row));
      cost.g += 5 * (J.transpose() * n);
    }
  }

  /// Whether all three true planes are kept at velocity v, drawn about their estimates.
  bool Draw(Rng& rng, const Vector3d& v) const {
    bool all = true;
    for (const PlaneEstimate& plane : planes) {
      const double tilt1_rad = kTilt_rad * rng.Normal();  // one a line: their order is fixed
      const double tilt2_rad = kTilt_rad * rng.Normal();
      const Vector3d dn = tilt1_rad * plane.e1_W + tilt2_rad * plane.e2_W;
      const double d = plane.d_m + dn.dot(plane.p_WCentroid) + kShift_m * rng.Normal();
      const Vector3d n = plane.n_W + dn;
      all = n.dot(v) >= -(n.dot(t) - d - kSafe_m) && all;
    }
    return all;
  }

  Vector3d t;
  PlaneEstimate planes[kPlanes];
  QuadraticCost cost;
  ConstraintSet set;
};

TEST(JointRisk, AllRowsHoldTogetherWithTheStatedProbability) {
  static ChanceQp qp(12);
  constexpr int kDraws = 100000;
  for (const double alpha : {0.7, 0.9, 0.95, 0.99, 0.999}) {
    for (int i = 0; i < 3; ++i) {
      SCOPED_TRACE(testing::Message() << alpha << ", seed " << i);
      Rng rng(1, i);
      const auto corner = std::make_unique<Corner>(rng);
      const auto share = [&](double z) {
        corner->set.z = z;
        const Controls u =
            qp.Solve(corner->cost, corner->set, SvfiMode::kExact, Controls::Zero()).u;
        int held = 0;
        for (const ChanceRow& row : corner->set.chance) {
          EXPECT_NEAR(ChanceExcess(row, u, z), 0, 1e-5) << "not active";
        }
        for (int k = 0; k < kDraws; ++k) {
          held += corner->Draw(rng, corner->set.chance[0].J * u) ? 1 : 0;
        }
        return static_cast<double>(held) / kDraws;
      };
      // One-sided binomial bounds at 99 % for all fifteen cases together.
      const double width = 3.21 * std::sqrt(alpha * (1 - alpha) / kDraws) + 0.5 / kDraws;
      EXPECT_GE(share(*JointChanceQuantile(alpha, kPlanes)), alpha - width);
      EXPECT_LT(share(*ChanceQuantile(alpha)), alpha - width) << "α of each is not α of all";
    }
  }
}

}  // namespace
}  // namespace pipewright
