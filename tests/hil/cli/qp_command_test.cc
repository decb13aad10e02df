// SPDX-License-Identifier: MIT
// `pipewright qp` as a person types it: answers in the file's variables, exit codes, and words for
// every file that is not what it says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "hil/cli/heap_watch.h"
#include "hil/qpb/qpb.h"
#include "tests/support/command_json.h"
#include "tests/support/qpb_file.h"

namespace pipewright::hil {
namespace {

using nlohmann::json;
using test::CommandResult;
using test::InfeasibleProblem;
using test::Parsed;
using test::SetBytes;
using test::SoftProblem;
using test::TestFolder;
using test::WriteFile;

namespace fs = std::filesystem;

constexpr const char* kOwnSets[] = {PIPEWRIGHT_TEST_DATA "/qp/mixed.qpb",
                                    PIPEWRIGHT_TEST_DATA "/qp/drift.qpb"};

CommandResult Qp(const std::string& arguments, const fs::path& folder) {
  return test::RunCommand(PIPEWRIGHT_BINARY, "qp " + arguments, folder);
}

/// Runs it on a file of these bytes.
CommandResult QpOn(const std::string& bytes, const std::string& options = "--repeat 1") {
  static const fs::path folder = TestFolder();
  WriteFile(folder / "set.qpb", bytes);
  return Qp("set.qpb " + options, folder);
}

double WorstViolation(const QpbProblem& p, const std::vector<double>& x) {
  double worst = 0;
  const auto see = [&worst](double y, double lo, double hi) {
    worst = std::max({worst, y - hi, lo - y});
  };
  const auto product = [&](const std::vector<double>& A, int i) {
    double y = 0;
    for (int j = 0; j < p.n; ++j) {
      y += A[i * p.n + j] * x[j];
    }
    return y;
  };
  for (int i = 0; i < p.equalities(); ++i) {
    see(product(p.Ae, i), p.be[i], p.be[i]);
  }
  for (int i = 0; i < p.inequalities(); ++i) {
    see(product(p.Ai, i), p.l[i], p.u[i]);
  }
  for (int j = 0; j < p.n; ++j) {
    see(x[j], p.lb[j], p.ub[j]);
  }
  return worst;
}

/// What the command says of a file, against the file.
json ExpectSolved(const std::string& file, const std::string& options) {
  SCOPED_TRACE(file + " " + options);
  const CommandResult result = Qp("'" + file + "' --json " + options, TestFolder());
  const json run = Parsed(result);
  const QpbResult read = ReadQpb(file);
  EXPECT_EQ(run["file"], file);
  EXPECT_EQ(run["problem_count"], read.set->problems.size());
  EXPECT_EQ(run["problems"].size(), read.set->problems.size());
  EXPECT_EQ(run["unexpected"], json::array());
  EXPECT_EQ(run["heap_allocations"], HeapWatch::Counting() ? json(0) : json(nullptr));
  EXPECT_LE(run["us"]["p50"], run["us"]["p99"]);
  EXPECT_LE(run["us"]["p99"], run["us"]["max"]);
  for (std::size_t k = 0; k < run["problems"].size(); ++k) {
    SCOPED_TRACE(k);
    const json& said = run["problems"][k];
    const QpbProblem& p = read.set->problems[k];
    EXPECT_EQ(said["status"], p.infeasible ? "infeasible" : "optimal");
    EXPECT_GE(said["iterations"], 0);
    if (p.infeasible) {
      EXPECT_TRUE(said["kkt"].is_null());
      EXPECT_EQ(said["x"], json::array());
      continue;
    }
    EXPECT_LT(said["kkt"], 1e-8);
    const auto x = said["x"].get<std::vector<double>>();
    EXPECT_EQ(x.size(), static_cast<std::size_t>(p.n));
    EXPECT_LT(WorstViolation(p, x), 1e-9);
  }
  return run;
}

int Iterations(const json& run) {
  int sum = 0;
  for (const json& problem : run["problems"]) {
    sum += problem["iterations"].get<int>();
  }
  return sum;
}

TEST(QpCommand, TeachesByHelp) {
  const CommandResult help = Qp("--help", TestFolder());
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_EQ(help.error, "");
  for (const char* expected : {"FILE", "--warm", "--repeat", "--json", "least", "KKT", "Exit code",
                               "Example: pipewright qp"}) {
    EXPECT_NE(help.out.find(expected), std::string::npos) << expected;
  }
}

TEST(QpCommand, FindsAnAnswerKnownByHandSlackIncluded) {
  const json run = Parsed(QpOn(SetBytes({SoftProblem()}), "--json"));
  ASSERT_EQ(run["problems"].size(), 1u);
  const auto x = run["problems"][0]["x"].get<std::vector<double>>();
  ASSERT_EQ(x.size(), 3u);
  EXPECT_NEAR(x[0], -0.75, 1e-12);
  EXPECT_NEAR(x[1], 2, 1e-12);
  EXPECT_NEAR(x[2], 0.25, 1e-12);
  QpbProblem below = SoftProblem();  // the same from the other side: x0 - s >= 1
  below.l[0] = 1;
  below.u[0] = 1e30;
  const json other = Parsed(QpOn(SetBytes({below}), "--json"));
  EXPECT_NEAR(other["problems"][0]["x"][0], 0.75, 1e-12);
  EXPECT_NEAR(other["problems"][0]["x"][2], -0.25, 1e-12);
}

TEST(QpCommand, SolvesTheRepositorysOwnSets) {
  for (const char* file : kOwnSets) {
    ExpectSolved(file, "");
    ExpectSolved(file, "--warm --repeat 2");
  }
}

TEST(QpCommand, StartsWarmOnlyWhenAskedAndAnswersTheSame) {
  const json cold = ExpectSolved(kOwnSets[1], "--repeat 3");
  const json again = ExpectSolved(kOwnSets[1], "--repeat 1");
  const json warm = ExpectSolved(kOwnSets[1], "--warm --repeat 3");
  EXPECT_EQ(Iterations(cold), Iterations(again));
  EXPECT_LT(2 * Iterations(warm), Iterations(cold));
  EXPECT_EQ(warm["problems"][0]["iterations"], cold["problems"][0]["iterations"]);
  double largest_us = 0;  // of those that have one before them
  for (std::size_t k = 1; k < warm["problems"].size(); ++k) {
    largest_us = std::max(largest_us, warm["problems"][k]["us"].get<double>());
  }
  EXPECT_NEAR(warm["us"]["max"], largest_us, 1e-3);
  for (std::size_t k = 0; k < cold["problems"].size(); ++k) {
    const json& x = cold["problems"][k]["x"];
    EXPECT_EQ(x, again["problems"][k]["x"]);
    for (std::size_t j = 0; j < x.size(); ++j) {
      EXPECT_NEAR(warm["problems"][k]["x"][j], x[j].get<double>(), 1e-8);
    }
  }
}

/// A box of n variables, each pulled to 2 and held at 1.
QpbProblem Box(int n, int rows) {
  QpbProblem p;
  p.n = n;
  const auto size = static_cast<std::size_t>(n);
  p.H.resize(size * size);
  for (int i = 0; i < n; ++i) {
    p.H[i * n + i] = 1;
  }
  p.g.resize(size, -2.0);
  p.Ai.resize(size * static_cast<std::size_t>(rows));
  for (int i = 0; i < rows; ++i) {
    p.Ai[i * n + i % n] = 1;
  }
  p.l.resize(static_cast<std::size_t>(rows), -1e30);
  p.u.resize(static_cast<std::size_t>(rows), 1.5);
  p.lb.resize(size, -1e30);
  p.ub.resize(size, 1.0);
  return p;
}

TEST(QpCommand, HoldsEverySizeUpToItsLargestAndSaysWhatThatIs) {
  std::vector<QpbProblem> problems;
  for (const int n : {1, 4, 5, 6, 9, 10, 11, 20, 21, 31, 32}) {
    for (const int rows : {0, 1, 40, 41, 80, 81, 104, 105, 256}) {
      problems.push_back(Box(n, rows));
    }
  }
  for (const char* options : {"--json --repeat 1", "--json --repeat 1 --warm"}) {
    const CommandResult result = QpOn(SetBytes(problems), options);
    const json run = Parsed(result);
    for (std::size_t k = 0; k < problems.size(); ++k) {
      for (const double x : run["problems"][k]["x"]) {
        EXPECT_NEAR(x, 1, 1e-12) << "problem " << k;
      }
    }
  }
  for (const QpbProblem& large : {Box(33, 1), Box(1, 257)}) {
    const CommandResult result = QpOn(SetBytes({SoftProblem(), large}));
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.error.find("problem 1: "), std::string::npos) << result.error;
    EXPECT_NE(result.error.find("32 and 256"), std::string::npos) << result.error;
  }
}

TEST(QpCommand, FailsWhenTheFileExpectsAnotherVerdict) {
  QpbProblem soft = SoftProblem();
  soft.infeasible = true;
  QpbProblem crossed = InfeasibleProblem();
  crossed.infeasible = false;
  const CommandResult result = QpOn(SetBytes({SoftProblem(), soft, crossed}), "--json");
  EXPECT_EQ(Parsed(result, 1)["unexpected"], json({1, 2}));
  const CommandResult table = QpOn(SetBytes({SoftProblem(), soft, crossed}));
  EXPECT_EQ(table.exit_code, 1);
  for (const char* expected : {"expected infeasible", "expected optimal", "2 not as expected"}) {
    EXPECT_NE(table.out.find(expected), std::string::npos) << table.out;
  }
}

TEST(QpCommand, CallsLimitsThatCrossInfeasibleSoftRowsIncluded) {
  for (const int row : {0, 1}) {
    QpbProblem p = SoftProblem();
    p.l[row] = p.u[row] + 1;
    p.infeasible = true;
    EXPECT_EQ(QpOn(SetBytes({p})).exit_code, 0) << row;
  }
}

TEST(QpCommand, PrintsATableForPeople) {
  const CommandResult result = QpOn(SetBytes({SoftProblem(), InfeasibleProblem()}));
  EXPECT_EQ(result.exit_code, 0);
  for (const char* expected :
       {"optimal", "infeasible", "set.qpb: 2 problems", "p50", "p99", "max", "heap allocations"}) {
    EXPECT_NE(result.out.find(expected), std::string::npos) << expected << " in\n" << result.out;
  }
}

TEST(QpCommand, SaysWhatIsWrongAndPrintsNoResult) {
  QpbProblem flat = SoftProblem();
  flat.H[0] = 0;
  const std::string good = SetBytes({SoftProblem()});
  const struct {
    const char* what;
    std::string bytes;
    const char* options;
    const char* expected;
  } cases[] = {
      {"empty", "", "", "set.qpb: is cut short at byte 0"},
      {"not QPB1", "name = 1\n", "", "set.qpb: is not QPB1"},
      {"cut short", good.substr(0, 100), "", "set.qpb: is cut short at byte 100"},
      {"not convex", SetBytes({SoftProblem(), flat}), "--json", "problem 1: H is not positive"},
      {"no passes", good, "--repeat 0", "--repeat"},
      {"no number", good, "--repeat nan", "--repeat"},
      {"an option of another command", good, "--seed 3", "--seed"},
      {"two files", good, "set.qpb", "set.qpb"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    const CommandResult result = QpOn(c.bytes, c.options);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.error.find(c.expected), std::string::npos) << result.error;
  }
  EXPECT_EQ(Qp("", TestFolder()).exit_code, 2);
  const CommandResult missing = Qp("none.qpb", TestFolder());
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_NE(missing.error.find("none.qpb: no such file"), std::string::npos) << missing.error;
}

TEST(QpCommand, TakesAFileWhoseNameIsNotText) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "\xff.qpb", SetBytes({SoftProblem()}));
  const CommandResult result = Qp("\xff.qpb --json", folder);
  EXPECT_EQ(Parsed(result)["problem_count"], 1);
}

TEST(QpCommand, EndsProperlyWhateverByteIsWrong) {
  const std::string good = SetBytes({SoftProblem(), InfeasibleProblem()});
  for (std::size_t at = 0; at < good.size(); at += 3) {
    SCOPED_TRACE(at);
    std::string flipped = good;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << at % 8));
    const CommandResult result = QpOn(flipped, "--json --repeat 1");
    EXPECT_TRUE(result.exit_code >= 0 && result.exit_code <= 2) << result.exit_code;
    EXPECT_EQ(result.exit_code == 2, !result.error.empty());
    EXPECT_EQ(result.exit_code == 2, result.out.empty());
    if (at % 5 == 0) {
      EXPECT_EQ(QpOn(good.substr(0, at)).exit_code, 2);
    }
  }
}

TEST(QpCommand, SolvesTheWholeCollection) {
  const char* const shared = std::getenv("PIPEWRIGHT_SHARED");
  if (shared == nullptr) {
    GTEST_SKIP() << "SKIPPED: set PIPEWRIGHT_SHARED to the folder that holds data/qp to solve the "
                    "whole collection";
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(fs::path(shared) / "data/qp")) {
    if (entry.path().extension() == ".qpb") {
      ExpectSolved(entry.path().string(), "--repeat 1");
      ExpectSolved(entry.path().string(), "--repeat 1 --warm");
    }
  }
}

}  // namespace
}  // namespace pipewright::hil
