// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "ctrl/constraints/constraint_set.h"
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
constexpr double kEta_1ps = 1.5;

Controls RandomControls(Rng& rng, double size) {
  Controls u;
  for (int i = 0; i < kControls; ++i) {
    u(i) = size * rng.Uniform(-1, 1);
  }
  return u;
}

/// Turns of the heading move x and y along: correlated, as odometry's are.
StateCovariance RandomStateCovariance(Rng& rng, double base_m, double base_rad, double joint_rad) {
  Matrix3d L = Matrix3d::Zero();
  for (int i = 0; i < 9; ++i) {
    L(i) = rng.Uniform(-0.6, 0.6);
  }
  L = Vector3d(base_m, base_m, base_rad).asDiagonal() * (Matrix3d::Identity() + L);
  StateCovariance covariance;
  covariance.base = L * L.transpose();
  for (int j = 0; j < kArmJoints; ++j) {
    covariance.joint_rad2(j) = std::pow(joint_rad * rng.Uniform(0.5, 1), 2);
  }
  return covariance;
}

/// One robot point before one primitive: a plane, a pipe's axis or a pipe's end.
struct Pair {
  Pair(Rng& rng, int which) : q(RandomConfiguration(rng)), is_plane(which == 0) {
    body = 1 + rng.Index(Kinematics<kArmJoints>::kBodies - 1);
    p_L = RandomIn(rng, 0.1 * kLo, 0.1 * kHi);
    const Vector3d t = At(q).Point(body, p_L);
    plane = MakePlane(1, t - 0.3 * RandomDirection(rng), RandomDirection(rng), 9, 0, 0);
    const Vector3d l = RandomDirection(rng);
    pipe = MakePipe(1, t + 0.3 * l.unitOrthogonal() + 0.2 * l, l, 0.05, 5, 0, 0);
    if (which == 2) {
      pipe.extent_lo_m = pipe.extent_hi_m = 2;
    }
  }
  static Kinematics<kArmJoints> At(const Configuration& q) { return {TracerUf7(), q}; }

  PointDistance Distance(const Vector3d& t) const {
    return is_plane ? PointToPlane(t, plane) : PointToPipeAxis(t, pipe, 0).to_axis;
  }
  /// f = ∇d(t)'v + η d(t)
  double F(const Vector3d& t, const Vector3d& v) const {
    const PointDistance d = Distance(t);
    return d.gradient_W.dot(v) + kEta_1ps * d.d_m;
  }
  VelocityCone Cone(const StateCovariance& covariance) const {
    const Kinematics<kArmJoints> k = At(q);
    const Vector3d t = k.Point(body, p_L);
    VelocityCone cone;
    const Mat<3, kControls> J = k.PointJacobian(body, p_L);
    const PointSpread spread = WithBase(SpreadOf(covariance.joint_rad2, J), covariance.base, J);
    const Vector3d e = Distance(t).gradient_W;
    if (is_plane) {
      AddStateVariance(spread, e, kEta_1ps, cone);
    } else {
      AddStateVariance(spread, e, PipeCurvature(pipe, PointToPipeAxis(t, pipe, 0)), kEta_1ps, cone);
    }
    return cone;
  }

  Configuration q;
  bool is_plane;
  int body = 0;
  Vector3d p_L;
  PlaneEstimate plane;
  PipeEstimate pipe;
};

TEST(AddStateVariance, IsTheFirstOrderDeviationByFiniteDifferences) {
  for (int i = 0; i < 600; ++i) {
    SCOPED_TRACE(i);
    Rng rng(1, i);
    const Pair pair(rng, i % 3);
    const Controls u = RandomControls(rng, 0.5);
    const StateCovariance covariance = RandomStateCovariance(rng, 0.02, 0.05, 0.01);
    const Vector3d v = Pair::At(pair.q).PointJacobian(pair.body, pair.p_L) * u;
    Configuration gradient;
    constexpr double kStep = 1e-6;
    for (int k = 0; k < kDof; ++k) {
      double f[2];
      for (int side = 0; side < 2; ++side) {
        Configuration moved = pair.q;
        moved(k) += side == 0 ? -kStep : kStep;
        const Kinematics<kArmJoints> at = Pair::At(moved);
        // The base's error turns v too; for a joint's, J_t counts as known.
        const Vector3d v_moved = k < 3 ? Vector3d(at.PointJacobian(pair.body, pair.p_L) * u) : v;
        f[side] = pair.F(at.Point(pair.body, pair.p_L), v_moved);
      }
      gradient(k) = (f[1] - f[0]) / (2 * kStep);
    }
    const Vector3d base = gradient.head<3>();
    const ArmVector joints = gradient.tail<kArmJoints>();
    const double variance =
        base.dot(covariance.base * base) + joints.cwiseAbs2().dot(covariance.joint_rad2);
    EXPECT_NEAR(pair.Cone(covariance).Sigma(v), std::sqrt(variance), 1e-8);
  }
}

/// Lower bound of a binomial share that 99 of 100 honest experiments stay above.
double Least(double alpha, int n) {
  return alpha - 2.326 * std::sqrt(alpha * (1 - alpha) / n) - 0.5 / n;
}

/// The true q is drawn about the known one, everything recomputed from it, J_t(q) u included: what
/// is left out must not show.
TEST(AddStateVariance, TheTrueConfigurationKeepsTheDistanceWithTheStatedProbability) {
  constexpr int kPairs = 60;
  constexpr int kDraws = 2000;
  constexpr double kAlpha = 0.95;
  constexpr double kFirstOrder = 0.005;  // what the curvature of q -> f may take
  const double z = *ChanceQuantile(kAlpha);
  int held = 0;
  int held_without = 0;
  for (int i = 0; i < kPairs; ++i) {
    Rng rng(2, i);
    const Pair pair(rng, i % 3);
    const Controls u = RandomControls(rng, 0.3);
    const StateCovariance covariance = RandomStateCovariance(rng, 0.005, 0.01, 0.003);
    const Kinematics<kArmJoints> known = Pair::At(pair.q);
    const Vector3d t = known.Point(pair.body, pair.p_L);
    const Vector3d v = known.PointJacobian(pair.body, pair.p_L) * u;
    // The row is active: f's mean is z σ_f above its bound.
    const double bound = pair.F(t, v) - z * pair.Cone(covariance).Sigma(v);
    const Matrix3d L = covariance.base.llt().matrixL();
    for (int k = 0; k < kDraws; ++k) {
      Configuration q = pair.q;
      q.head<3>() += L * Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
      for (int j = 0; j < kArmJoints; ++j) {
        q(3 + j) += std::sqrt(covariance.joint_rad2(j)) * rng.Normal();
      }
      const Kinematics<kArmJoints> at = Pair::At(q);
      const double f =
          pair.F(at.Point(pair.body, pair.p_L), at.PointJacobian(pair.body, pair.p_L) * u);
      held += f >= bound ? 1 : 0;
      held_without += f >= pair.F(t, v) ? 1 : 0;
    }
  }
  constexpr int kAll = kPairs * kDraws;
  EXPECT_GE(static_cast<double>(held) / kAll, Least(kAlpha - kFirstOrder, kAll)) << held;
  EXPECT_LT(static_cast<double>(held_without) / kAll, 0.6);  // the test can tell
}

TEST(AddStateVariance, ChangesNoBitWithoutCovariance) {
  static ConstraintSet known;
  static ConstraintSet zero;
  static ConstraintSet unsure;
  const test::VoxelWorld world;
  for (int i = 0; i < 30; ++i) {
    Rng rng(3, i);
    Scene scene;
    for (std::uint32_t k = 1; k <= 4; ++k) {
      ASSERT_TRUE(scene.planes.push_back(
          MakePlane(k, RandomIn(rng, kLo, kHi), RandomDirection(rng), 2, 0.02, 0.01)));
      ASSERT_TRUE(scene.pipes.push_back(
          MakePipe(k, RandomIn(rng, kLo, kHi), RandomDirection(rng), 0.05, 0.3, 0.01, 0.02)));
    }
    const Configuration q = RandomConfiguration(rng);
    const Controls u_sent = RandomControls(rng, 0.2);
    const Kinematics<kArmJoints> k(TracerUf7(), q);
    const ConstraintBuilder builder({}, TracerUf7(), TracerUf7Shapes());
    const StateCovariance none;
    const StateCovariance some = RandomStateCovariance(rng, 0.01, 0.02, 0.005);
    builder.Build(q, k, u_sent, scene, world.field(), known);
    builder.Build(q, k, u_sent, scene, world.field(), zero, &none);
    builder.Build(q, k, u_sent, scene, world.field(), unsure, &some);
    ASSERT_EQ(known.chance.size(), zero.chance.size());
    for (int r = 0; r < known.chance.size(); ++r) {
      const ChanceRow& a = known.chance[r];
      const ChanceRow& b = zero.chance[r];
      EXPECT_EQ(a.a, b.a);
      EXPECT_EQ(a.limit, b.limit);
      EXPECT_EQ(a.cone.Q, b.cone.Q);
      EXPECT_EQ(a.cone.q, b.cone.q);
      EXPECT_EQ(a.cone.c, b.cone.c);
    }
    for (const ChanceRow& row : unsure.chance) {  // standing still stays allowed
      EXPECT_TRUE(row.price > 0 || ChanceExcess(row, Controls::Zero(), unsure.z) <= 1e-15);
    }
    if (!known.chance.empty() && !known.chance.full()) {
      ASSERT_EQ(known.chance.size(), unsure.chance.size());
      EXPECT_GT(unsure.chance[0].cone.c, known.chance[0].cone.c);
    }
  }
}

}  // namespace
}  // namespace pipewright
