// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "ctrl/qp/dual_active_set_inl.h"
#include "ctrl/whole_body/whole_body_controller.h"
#include "platform/robot/state_history.h"
#include "tests/ctrl/constraints/random_world.h"

namespace pipewright {
namespace {

using test::RandomDirection;
using test::RandomIn;

constexpr int kSlacks = 20;
constexpr int kFull = kDof + kSlacks;
using FullQp = QpProblem<kFull, 200>;

Vec<6> SensorAt(const Configuration& q) {
  const Kinematics<kArmJoints> k(TracerUf7(), q);
  Vec<6> x;
  x << k.p_WS(), k.z_WS();
  return x;
}

/// Law (3) as printed: q' has ten entries, the lateral speed is an equality row, soft rows have
/// slacks as variables, the task's Jacobian comes from differences. Nothing here is eliminated.
void PoseFullLaw(const WholeBodyConfig& config, const Configuration& q, const Goal& goal,
                 const ConstraintSet& set, FullQp& qp) {
  Mat<6, kDof> J;
  constexpr double kStep = 1e-6;
  for (int i = 0; i < kDof; ++i) {
    Configuration hi = q;
    Configuration lo = q;
    hi(i) += kStep;
    lo(i) -= kStep;
    J.col(i) = (SensorAt(hi) - SensorAt(lo)) / (2 * kStep);
  }
  Vec<6> x_d;
  x_d << goal.p_WS, goal.z_WS;
  qp.H.setZero();
  qp.g.setZero();
  qp.H.topLeftCorner<kDof, kDof>() = 2 * J.transpose() * J;
  qp.H.diagonal().head<kDof>().array() += 2 * config.lambda_c;
  qp.H.diagonal().tail<kSlacks>().setConstant(2 * 5e3);
  qp.g.head<kDof>() = 2 * config.kappa_1ps * J.transpose() * (SensorAt(q) - x_d);
  qp.ClearRows();
  Vec<kFull> a = Vec<kFull>::Zero();
  a(0) = std::sin(q(2));
  a(1) = -std::cos(q(2));
  ASSERT_TRUE(qp.AddRow(a, 0, 0));
  int slack = 0;
  const auto lift = [&](const Controls& u_row) {
    Vec<kFull> row = Vec<kFull>::Zero();
    row(0) = u_row(0) * std::cos(q(2));
    row(1) = u_row(0) * std::sin(q(2));
    row.segment<kDof - 2>(2) = u_row.tail<kDof - 2>();
    return row;
  };
  const auto add = [&](const Controls& u_row, double lo, double hi, double price) {
    Vec<kFull> row = lift(u_row);
    if (price > 0) {
      ASSERT_LT(slack, kSlacks);
      row(kDof + slack++) = -1;
    }
    ASSERT_TRUE(qp.AddRow(row, lo, hi));
  };
  for (const Row& row : set.rows) {
    add(row.a, row.lo, row.hi, row.price);
  }
  for (const ChanceRow& row : set.chance) {
    add(row.a, -kInfinity, row.limit, row.price);
  }
  for (int i = 0; i < kControls; ++i) {
    add(Controls::Unit(i), set.lb(i), set.ub(i), 0);
  }
}

TEST(Law3, TheReducedQpHasTheMinimiserOfTheFullOneWithSlacksAndTheEqualityRow) {
  static FullQp full;
  static QpSolver<kFull, 200> solver;
  const test::VoxelWorld world;
  int active = 0;
  for (int i = 0; i < 90; ++i) {
    SCOPED_TRACE(i);
    Rng rng(1, i);
    WholeBodyConfig config;
    config.constraints.alpha = 0.5;  // the cones are half-spaces
    config.constraints.price[static_cast<int>(RowKind::kRecovery)] = 5e3;
    WholeBodyController controller(config, TracerUf7(), TracerUf7Shapes());
    ASSERT_EQ(controller.status(), Status::kOk);
    Configuration q = test::HomeConfiguration();
    for (int k = 0; k < kDof; ++k) {
      q(k) += rng.Uniform(-0.3, 0.3);
    }
    const Vec<6> x = SensorAt(q);
    Scene scene;
    Goal goal;
    goal.id = 1;
    goal.p_WS = x.head<3>() + 0.3 * RandomDirection(rng);
    goal.z_WS = (x.tail<3>() + 0.5 * RandomDirection(rng)).normalized();
    const Vector3d ahead = (goal.p_WS - x.head<3>()).normalized();
    ASSERT_TRUE(scene.planes.push_back(
        test::MakePlane(1, x.head<3>() + 0.2 * ahead, -ahead, 0.05, 0.01, 0.01)));
    ASSERT_TRUE(scene.pipes.push_back(test::MakePipe(2, x.head<3>() + 0.25 * RandomDirection(rng),
                                                     RandomDirection(rng), 0.03, 0.01, 0, 0)));
    RobotState state;
    state.q = q;
    state.valid = true;
    ControlOutput out;
    for (int step = 0; step < 30; ++step) {  // past the acceleration's limit
      out = controller.Step({state, scene, world.field(), goal}, Time{});
    }
    int soft = 0;
    for (const Row& row : controller.constraints().rows) {
      soft += row.price > 0 ? 1 : 0;
    }
    for (const ChanceRow& row : controller.constraints().chance) {
      soft += row.price > 0 ? 1 : 0;
    }
    if (soft > kSlacks) {
      continue;
    }
    PoseFullLaw(config, q, goal, controller.constraints(), full);
    const auto& solution = solver.Solve(full);
    ASSERT_EQ(solution.status, QpStatus::kOptimal);
    EXPECT_EQ(out.stats.qp.status, QpStatus::kOptimal);
    Vec<kDof> rate;
    rate << out.u(0) * std::cos(q(2)), out.u(0) * std::sin(q(2)), out.u.tail<kDof - 2>();
    EXPECT_LT((rate - solution.x.head<kDof>()).cwiseAbs().maxCoeff(), 1e-6);
    active += solution.lambda_rows.cwiseAbs().maxCoeff() > 1e-3 ? 1 : 0;
  }
  EXPECT_GT(active, 10);
}

TEST(Law3, LateralSpeedIsZeroByForm) {
  for (int i = 0; i < 1000; ++i) {
    Rng rng(2, i);
    Controls u = Controls::Zero();
    u(0) = rng.Uniform(-0.4, 0.4);
    Configuration q = Configuration::Zero();
    q(2) = rng.Uniform(-3, 3);
    const Configuration next = Advance(q, u, 0.01);
    const Eigen::Vector2d lateral{std::sin(q(2)), -std::cos(q(2))};
    EXPECT_LT(std::abs(lateral.dot((next - q).head<2>()) / 0.01), 1e-15);
  }
}

}  // namespace
}  // namespace pipewright
