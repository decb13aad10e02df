// SPDX-License-Identifier: MIT
#include "hil/qpb/qpb.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "tests/support/command.h"
#include "tests/support/qpb_file.h"

namespace pipewright::hil {
namespace {

namespace fs = std::filesystem;

using test::SetBytes;
using test::SoftProblem;

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

QpbResult Read(const std::string& bytes) {
  static const fs::path folder = test::TestFolder();
  test::WriteFile(folder / "set.qpb", bytes);
  return ReadQpb(folder / "set.qpb");
}

void ExpectRefused(const std::string& bytes, const std::string& words) {
  const QpbResult read = Read(bytes);
  EXPECT_FALSE(read.set.has_value());
  EXPECT_NE(read.error.find("set.qpb: "), std::string::npos) << read.error;
  EXPECT_NE(read.error.find(words), std::string::npos) << read.error;
}

/// The bytes of a good set, an int32 of its head replaced: 1 problems, 2 is_sequence, of problem 0
/// 3 n, 4 me, 5 mi, 6 ns, 7 expect, 8 soft_row[0].
std::string WithInt(int which, std::int32_t value) {
  std::string bytes = SetBytes({SoftProblem()});
  std::memcpy(bytes.data() + 4 * which, &value, 4);
  return bytes;
}

TEST(Qpb, IsReadAsItWasWritten) {
  const QpbResult read =
      Read(SetBytes({SoftProblem(), test::InfeasibleProblem()}, /*is_sequence=*/true));
  ASSERT_EQ(read.error, "");
  ASSERT_TRUE(read.set.has_value());
  EXPECT_TRUE(read.set->is_sequence);
  ASSERT_EQ(read.set->problems.size(), 2u);
  const QpbProblem& p = read.set->problems[0];
  EXPECT_EQ(p.n, 3);
  EXPECT_EQ(p.equalities(), 1);
  EXPECT_EQ(p.inequalities(), 2);
  EXPECT_EQ(p.kept(), 2);
  EXPECT_FALSE(p.infeasible);
  EXPECT_EQ(p.soft_row, std::vector<int>{0});
  EXPECT_EQ(p.H, SoftProblem().H);
  EXPECT_EQ(p.g, SoftProblem().g);
  EXPECT_EQ(p.Ae, SoftProblem().Ae);
  EXPECT_EQ(p.be, SoftProblem().be);
  EXPECT_EQ(p.Ai, SoftProblem().Ai);
  EXPECT_EQ(p.l, (std::vector<double>{-kInf, -4}));
  EXPECT_EQ(p.u, (std::vector<double>{-1, 9}));
  EXPECT_EQ(p.lb, (std::vector<double>{-5, -kInf, -kInf}));
  EXPECT_EQ(p.ub, (std::vector<double>{kInf, kInf, kInf}));
  EXPECT_TRUE(read.set->problems[1].infeasible);
  EXPECT_EQ(read.set->problems[1].slacks(), 0);
}

TEST(Qpb, SaysWhichProblemIsNotAsDocumented) {
  const struct {
    const char* what;
    void (*spoil)(QpbProblem&);
    const char* expected;
  } cases[] = {
      {"H", [](QpbProblem& p) { p.H[4] = kNan; }, "H[1][1] is nan"},
      {"H", [](QpbProblem& p) { p.H[4] = kInf; }, "H[1][1] is inf"},
      {"H", [](QpbProblem& p) { p.H[1] = 0.5; }, "not symmetric"},
      {"g", [](QpbProblem& p) { p.g[1] = kNan; }, "g[1] is nan"},
      {"Ae", [](QpbProblem& p) { p.Ae[0] = -kInf; }, "Ae[0][0] is -inf"},
      {"be", [](QpbProblem& p) { p.be[0] = kInf; }, "be[0] is inf"},
      {"Ai", [](QpbProblem& p) { p.Ai[4] = kNan; }, "Ai[1][1] is nan"},
      {"l", [](QpbProblem& p) { p.l[1] = kNan; }, "l[1] is nan"},
      {"l", [](QpbProblem& p) { p.l[1] = kInf; }, "l[1] is inf"},
      {"u", [](QpbProblem& p) { p.u[0] = -kInf; }, "u[0] is -inf"},
      {"lb", [](QpbProblem& p) { p.lb[0] = kInf; }, "lb[0] is inf"},
      {"ub", [](QpbProblem& p) { p.ub[1] = kNan; }, "ub[1] is nan"},
      {"row", [](QpbProblem& p) { p.soft_row[0] = 2; }, "soft_row[0] is 2; there are 2 rows"},
      {"row", [](QpbProblem& p) { p.soft_row[0] = 1; }, "coefficient 0 there, not -1"},
      {"row",
       [](QpbProblem& p) {
         p.soft_row = {0, 0};
       },
       "another slack softens already"},
      {"sign", [](QpbProblem& p) { p.Ai[2] = 1; }, "coefficient 1 there, not -1"},
      {"other row", [](QpbProblem& p) { p.Ai[5] = 1; }, "stands in another row"},
      {"other row", [](QpbProblem& p) { p.Ae[2] = 1; }, "stands in another row"},
      {"coupled", [](QpbProblem& p) { p.H[2] = p.H[6] = 0.1; }, "coupled to another variable"},
      {"price", [](QpbProblem& p) { p.H[8] = 0; }, "has the price 0"},
      {"price", [](QpbProblem& p) { p.H[8] = -3; }, "has the price -3"},
      {"price", [](QpbProblem& p) { p.H[8] = 1e-320; }, "has the price 1e-320"},
      {"cost", [](QpbProblem& p) { p.g[2] = 0.5; }, "linear cost 0.5"},
      {"bounded", [](QpbProblem& p) { p.lb[2] = 0; }, "bounded, not free"},
      {"bounded", [](QpbProblem& p) { p.ub[2] = 1; }, "bounded, not free"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    QpbProblem p = SoftProblem();
    c.spoil(p);
    ExpectRefused(SetBytes({SoftProblem(), p}), "problem 1: ");
    ExpectRefused(SetBytes({SoftProblem(), p}), c.expected);
  }
}

TEST(Qpb, TakesLimitsThatCrossForAProblemWithoutAnswerIsOneToo) {
  QpbProblem p = SoftProblem();
  p.l[1] = 10;
  EXPECT_EQ(Read(SetBytes({p})).error, "");
}

TEST(Qpb, RefusesCountsThatCannotBe) {
  constexpr std::int32_t kHuge = 0x7fffffff;
  ExpectRefused(WithInt(0, 0x32425051), "not QPB1");
  ExpectRefused(WithInt(1, 0), "the number of problems is 0 (byte 4)");
  ExpectRefused(WithInt(1, -1), "the number of problems is -1");
  ExpectRefused(WithInt(1, kHuge), "is cut short");
  ExpectRefused(WithInt(2, 2), "is_sequence is 2 (byte 8), not from 0 to 1");
  ExpectRefused(WithInt(3, 0), "problem 0: n is 0 (byte 12)");
  ExpectRefused(WithInt(3, -5), "problem 0: n is -5");
  ExpectRefused(WithInt(4, -1), "problem 0: me is -1 (byte 16)");
  ExpectRefused(WithInt(5, -1), "problem 0: mi is -1");
  ExpectRefused(WithInt(6, 3), "problem 0: ns is 3 (byte 24), not from 0 to 2");
  ExpectRefused(WithInt(6, -1), "problem 0: ns is -1");
  ExpectRefused(WithInt(7, 3), "problem 0: expect is 3");
  ExpectRefused(WithInt(8, -1), "problem 0: soft_row is -1");
  for (const int count : {3, 4, 5}) {
    ExpectRefused(WithInt(count, kHuge), "cut short");
  }
}

TEST(Qpb, SaysWhereAFileIsCutShort) {
  const std::string bytes = SetBytes({SoftProblem(), test::InfeasibleProblem()});
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    ExpectRefused(bytes.substr(0, length), "is cut short at byte " + std::to_string(length) + ":");
  }
  ExpectRefused(bytes + "12", "2 bytes after its last problem");
  ExpectRefused(SetBytes({SoftProblem()}).substr(0, 40), "problem 0: H begins at byte 36");
}

TEST(Qpb, EitherReadsOrSaysWhyWhateverByteIsWrong) {
  const std::string bytes = SetBytes({SoftProblem(), test::InfeasibleProblem()});
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (const int flip : {0x01, 0x10, 0x80, 0xff}) {
      std::string other = bytes;
      other[at] = static_cast<char>(other[at] ^ flip);
      const QpbResult read = Read(other);
      EXPECT_NE(read.set.has_value(), !read.error.empty());
    }
  }
}

TEST(Qpb, RefusesWhatIsNoFile) {
  EXPECT_EQ(ReadQpb("/nowhere/set.qpb").error, "/nowhere/set.qpb: no such file");
  EXPECT_EQ(ReadQpb("/").error, "/: is not a file");
  EXPECT_EQ(ReadQpb("/dev/zero").error, "/dev/zero: is not a file");  // would never end
  EXPECT_NE(ReadQpb("").error, "");
}

TEST(Qpb, ReadsTheRepositorysOwnSets) {
  const QpbResult drift = ReadQpb(PIPEWRIGHT_TEST_DATA "/qp/drift.qpb");
  ASSERT_TRUE(drift.set.has_value()) << drift.error;
  EXPECT_EQ(drift.set->problems.size(), 8u);
  EXPECT_TRUE(drift.set->is_sequence);
  EXPECT_EQ(drift.set->problems[0].n, 16);
  EXPECT_EQ(drift.set->problems[0].slacks(), 6);
  EXPECT_FALSE(ReadQpb(PIPEWRIGHT_TEST_DATA "/qp/README.md").set.has_value());
}

}  // namespace
}  // namespace pipewright::hil
