// SPDX-License-Identifier: MIT
// Random variations of the degenerate, ill-conditioned and infeasible problems of tests/data, and
// of the whole collection where PIPEWRIGHT_SHARED names the folder that holds data/qp. A variation
// keeps the set of feasible points: the verdict stays that of the file.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "ctrl/qp/dual_active_set_inl.h"
#include "hil/cli/qp_without_slacks.h"
#include "hil/qpb/qpb.h"
#include "tests/support/qp_problems.h"

namespace pipewright {
namespace {

// rapidcheck reads its seed from the environment; unless someone sets another, it is this one.
const bool kSeeded = setenv("RC_PARAMS", "seed=20261122 max_success=2000", 0) == 0;

constexpr int kN = 10;
constexpr int kM = 120;
using Problem = QpProblem<kN, kM>;

struct Known {
  Problem qp;
  bool infeasible = false;
};

std::vector<Known> Collect() {
  std::vector<std::string> files{PIPEWRIGHT_TEST_DATA "/qp/mixed.qpb"};
  if (const char* const shared = std::getenv("PIPEWRIGHT_SHARED")) {
    for (const char* name : {"c_dup", "c_neardup", "c_vertex", "c_depeq", "c_illcond", "c_thin",
                             "c_infeas", "c_infeas_tiny"}) {
      files.push_back(std::string(shared) + "/data/qp/" + name + ".qpb");
    }
  }
  std::vector<Known> all;
  for (const std::string& file : files) {
    const hil::QpbResult read = hil::ReadQpb(file);
    EXPECT_EQ(read.error, "");
    for (const hil::QpbProblem& p : read.set.value_or(hil::QpbSet{}).problems) {
      Known known;
      known.infeasible = p.infeasible;
      if (hil::WithoutSlacks(p, known.qp)) {
        all.push_back(known);
      }
    }
  }
  return all;
}

/// Another cost, of condition up to 1e4, rows in another order, scaled and negated, some repeated
/// with room to spare.
Problem Varied(const Problem& qp, Rng& rng) {
  Problem other = qp;
  other.H = test::RandomHessian<kN>(rng, std::pow(10, rng.Uniform(0, 4)));
  other.g = test::RandomVec<kN>(rng, std::pow(10, rng.Uniform(-1, 2)));
  other.ClearRows();
  std::vector<int> order;
  for (int i = 0; i < qp.rows; ++i) {
    order.push_back(i);
    if (rng.Uniform() < 0.3) {
      order.push_back(i);
    }
  }
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[rng.Index(static_cast<int>(i))]);
  }
  std::vector<bool> seen(static_cast<std::size_t>(qp.rows), false);
  for (const int i : order) {
    const bool again = seen[static_cast<std::size_t>(i)];
    seen[static_cast<std::size_t>(i)] = true;
    if (again && (qp.price[i] > 0 || qp.lo[i] == qp.hi[i])) {
      continue;  // a soft row twice costs twice
    }
    const double room = again ? rng.Uniform(0, 1) : 0;
    const double scale = rng.Uniform(0.3, 3) * (rng.Uniform() < 0.5 ? -1 : 1);
    const double first = scale * (qp.lo[i] - room);
    const double second = scale * (qp.hi[i] + room);
    (void)other.AddRow(scale * qp.A.row(i).transpose(), std::min(first, second),
                       std::max(first, second), qp.price[i] / (scale * scale), i);
  }
  return other;
}

double RelativeResidual(const Problem& qp, const QpSolution<kN, kM>& s) {
  const double size =
      std::max({1.0, qp.g.cwiseAbs().maxCoeff(), s.x.cwiseAbs().maxCoeff(),
                s.lambda_rows.cwiseAbs().maxCoeff(), s.lambda_box.cwiseAbs().maxCoeff()});
  return KktResidual(qp, s) / size;
}

TEST(Variations, OfHardProblemsKeepTheirVerdictColdAndWarm) {
  const std::vector<Known> all = Collect();
  ASSERT_GT(all.size(), 5U);
  const auto warm = std::make_unique<QpSolver<kN, kM>>();
  const auto cold = std::make_unique<QpSolver<kN, kM>>();
  const bool holds = rc::check("the verdict is the file's and an optimum is one", [&] {
    const Known& known = all[*rc::gen::inRange<std::size_t>(0, all.size())];
    Rng rng(*rc::gen::arbitrary<std::uint64_t>());
    const auto varied = std::make_unique<Problem>(Varied(known.qp, rng));
    cold->ForgetActiveSet();
    for (QpSolver<kN, kM>* solver : {cold.get(), warm.get()}) {
      const auto& s = solver->Solve(*varied);
      RC_ASSERT(s.status == (known.infeasible ? QpStatus::kInfeasible : QpStatus::kOptimal));
      if (!known.infeasible) {
        RC_ASSERT(RelativeResidual(*varied, s) <= 1e-9);
      }
    }
  });
  EXPECT_TRUE(holds);
}

}  // namespace
}  // namespace pipewright
