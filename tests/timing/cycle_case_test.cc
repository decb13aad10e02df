// SPDX-License-Identifier: MIT
#include "tests/timing/cycle_case.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <sstream>

#include "platform/robot/uf7.h"
#include "tests/timing/case_maker.h"
#include "tests/timing/case_runner.h"

namespace pipewright::timing {
namespace {

std::string Text(const CycleCase& c) {
  std::ostringstream out;
  Write(c, out);
  return out.str();
}

bool ReadText(const std::string& text, CycleCase& c, std::string& error) {
  std::istringstream in(text);
  return Read(in, c, error);
}

TEST(CycleCase, IsReadBackAsItWasWrittenAndCostsTheSame) {
  const InstructionCount none;
  CaseRunner runner(none);
  CaseMaker maker(3);
  CycleCase c = maker.Draw({});
  for (int i = 0; i < 10; ++i) {
    CycleCase back;
    std::string error;
    ASSERT_TRUE(ReadText(Text(c), back, error)) << error;
    EXPECT_EQ(Text(back), Text(c));
    const std::vector<CycleCost> first = runner.Run(c);
    const std::vector<CycleCost>& second = runner.Run(back);
    ASSERT_EQ(first.size(), second.size());
    for (std::size_t k = 0; k < first.size(); ++k) {
      EXPECT_EQ(first[k].stats.rows, second[k].stats.rows);
      EXPECT_EQ(first[k].stats.qp.iterations, second[k].stats.qp.iterations);
      EXPECT_EQ(static_cast<int>(second[k].solves.size()), second[k].stats.qp.rounds);
    }
    c = maker.Mutate(c);
  }
}

TEST(CycleCase, NamesTheLineThatIsNotUnderstood) {
  CycleCase c;
  std::string error;
  EXPECT_FALSE(ReadText("", c, error));
  EXPECT_FALSE(ReadText("pipewright cycle case 1\n", c, error));
  std::string text = Text(CaseMaker(1).Draw({}));
  text += "plane 1 2\n";
  EXPECT_FALSE(ReadText(text, c, error));
  const auto lines = std::count(text.begin(), text.end(), '\n');
  EXPECT_EQ(error, "line " + std::to_string(lines) + " is not understood");
}

template <typename M>
bool IsSemidefinite(const M& m) {
  const Eigen::SelfAdjointEigenSolver<M> solver(m);
  return solver.eigenvalues().minCoeff() >= -1e-9 * m.norm();
}

/// A case that is not lawful would blame the controller for what cannot be.
void ExpectLawful(const CycleCase& c) {
  for (const PlaneEstimate& plane : c.scene.planes) {
    EXPECT_NEAR(plane.n_W.norm(), 1, 1e-9);
    EXPECT_NEAR(plane.n_W.dot(plane.p_WCentroid), plane.d_m, 1e-9);
    EXPECT_TRUE(IsSemidefinite(plane.covariance));
  }
  for (const PipeEstimate& pipe : c.scene.pipes) {
    EXPECT_NEAR(pipe.l_W.norm(), 1, 1e-9);
    EXPECT_GT(pipe.radius_m, 0);
    EXPECT_TRUE(IsSemidefinite(pipe.covariance));
  }
  for (const CaseStep& step : c.steps) {
    EXPECT_NEAR(step.goal.z_WS.norm(), 1, 1e-9);
    for (int j = 0; j < kArmJoints; ++j) {
      EXPECT_LE(TracerUf7().arm.joints[j].q_min_rad, step.q(3 + j));
      EXPECT_GE(TracerUf7().arm.joints[j].q_max_rad, step.q(3 + j));
    }
  }
}

TEST(CaseMaker, StaysLawfulHoweverLongItChangesACase) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    CaseMaker maker(seed);
    CycleCase c = seed == 1 ? maker.Crowd({}) : maker.Draw({});
    for (int i = 0; i < 200; ++i) {
      c = maker.Mutate(c);
    }
    ExpectLawful(c);
  }
}

TEST(CaseMaker, CrowdsFillEveryRow) {
  const InstructionCount none;
  CaseRunner runner(none);
  const CycleCase crowd = CaseMaker(1).Crowd({});
  const CycleCost& last = runner.Run(crowd).back();
  EXPECT_EQ(last.stats.chance_rows, kMaxChanceRows);
  EXPECT_GT(last.stats.dropped_rows, 2 * kMaxChanceRows);
}

}  // namespace
}  // namespace pipewright::timing
