// SPDX-License-Identifier: MIT
// Problems from files: the small ones in tests/data always, the whole collection where
// PIPEWRIGHT_SHARED names the folder that holds data/qp.
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "ctrl/qp/dual_active_set_inl.h"
#include "hil/cli/qp_without_slacks.h"
#include "hil/qpb/qpb.h"
#include "platform/core/rng.h"

namespace pipewright {
namespace {

/// The KKT residual as a share of the problem's own size.
template <int n, int m>
double RelativeResidual(const QpProblem<n, m>& qp, const QpSolution<n, m>& s) {
  const double size =
      std::max({1.0, qp.g.cwiseAbs().maxCoeff(), s.x.cwiseAbs().maxCoeff(),
                s.lambda_rows.cwiseAbs().maxCoeff(), s.lambda_box.cwiseAbs().maxCoeff()});
  return KktResidual(qp, s) / size;
}

/// The same problem with its rows in another order, negated and scaled at random.
template <int n, int m>
QpProblem<n, m> Disguised(const QpProblem<n, m>& qp, Rng& rng) {
  QpProblem<n, m> other = qp;
  other.ClearRows();
  int order[m];
  for (int i = 0; i < qp.rows; ++i) {
    order[i] = i;
  }
  for (int i = qp.rows - 1; i > 0; --i) {
    std::swap(order[i], order[rng.Index(i + 1)]);
  }
  for (int k = 0; k < qp.rows; ++k) {
    const int i = order[k];
    const double scale = rng.Uniform(0.5, 2);
    const bool flip = rng.Uniform() < 0.5;
    (void)other.AddRow((flip ? -scale : scale) * qp.A.row(i).transpose(),
                       scale * (flip ? -qp.hi[i] : qp.lo[i]), scale * (flip ? -qp.lo[i] : qp.hi[i]),
                       qp.price[i] / (scale * scale), i);
  }
  return other;
}

template <int n, int m>
void SolveAll(const hil::QpbSet& set) {
  const auto warm = std::make_unique<QpSolver<n, m>>();
  const auto cold = std::make_unique<QpSolver<n, m>>();
  Rng rng(1);
  int number = 0;
  for (const hil::QpbProblem& p : set.problems) {
    SCOPED_TRACE(testing::Message() << "problem " << number++);
    auto qp = std::make_unique<QpProblem<n, m>>();
    ASSERT_TRUE(hil::WithoutSlacks(p, *qp));
    const QpStatus expected = p.infeasible ? QpStatus::kInfeasible : QpStatus::kOptimal;
    cold->ForgetActiveSet();
    const auto& c = cold->Solve(*qp);
    const auto& w = warm->Solve(*qp);
    ASSERT_EQ(c.status, expected);
    ASSERT_EQ(w.status, expected);
    if (!p.infeasible) {
      EXPECT_LE(RelativeResidual(*qp, c), 1e-9);
      EXPECT_LE(RelativeResidual(*qp, w), 1e-9);
    }
    for (int disguise = 0; disguise < 3; ++disguise) {
      const auto other = std::make_unique<QpProblem<n, m>>(Disguised(*qp, rng));
      const auto& d = warm->Solve(*other);
      ASSERT_EQ(d.status, expected) << "disguise " << disguise;
      if (!p.infeasible) {
        EXPECT_LE(RelativeResidual(*other, d), 1e-9);
      }
    }
  }
}

hil::QpbSet Read(const std::string& path) {
  const hil::QpbResult read = hil::ReadQpb(path);
  EXPECT_EQ(read.error, "");
  return read.set.value_or(hil::QpbSet{});
}

TEST(QpbSets, AreSolvedFromTheRepositorysOwnSample) {
  SolveAll<10, 80>(Read(PIPEWRIGHT_TEST_DATA "/qp/mixed.qpb"));
  SolveAll<10, 80>(Read(PIPEWRIGHT_TEST_DATA "/qp/drift.qpb"));
}

TEST(QpbSets, AreSolvedWithoutOneWrongVerdict) {
  const char* const shared = std::getenv("PIPEWRIGHT_SHARED");
  if (shared == nullptr) {
    GTEST_SKIP() << "SKIPPED: set PIPEWRIGHT_SHARED to the folder that holds data/qp to solve the "
                    "whole collection";
  }
  const std::string folder = std::string(shared) + "/data/qp/";
  for (const char* name : {"a_wbc_s", "a_wbc_m", "a_wbc_l", "b_rnd_n05_m010", "b_rnd_n05_m025",
                           "b_rnd_n10_m020", "b_rnd_n10_m050", "c_dup", "c_neardup", "c_vertex",
                           "c_depeq", "c_illcond", "c_thin", "c_infeas", "c_infeas_tiny"}) {
    SCOPED_TRACE(name);
    SolveAll<10, 80>(Read(folder + name + ".qpb"));
  }
  for (const char* name : {"b_rnd_n20_m040", "b_rnd_n20_m100"}) {
    SCOPED_TRACE(name);
    SolveAll<20, 104>(Read(folder + name + ".qpb"));
  }
}

}  // namespace
}  // namespace pipewright
