// SPDX-License-Identifier: MIT
// Whether the judges of the fault bench see what is wrong: else its zeros would say nothing.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/bench/faults/command_judge.h"
#include "tests/bench/faults/fault_rig.h"
#include "tests/bench/faults/outcome.h"
#include "tests/bench/faults/rows.h"

namespace pipewright::bench {
namespace {

using std::chrono_literals::operator""ms;

TEST(CommandJudge, LetsALawfulMotionPass) {
  CommandJudge judge;
  Time now{};
  for (int v = 0; v <= 400; v += 16) {
    judge.Take(test::SentTwist{now += 20ms, v, -2 * v});
  }
  judge.Take(test::SentTwist{now += 20ms, 0, 0});  // stops at once
  for (int u = 0; u <= 1'000'000; u += 100'000) {
    judge.Take(test::SentJoint{now += 10ms, 3, u});
  }
  EXPECT_EQ(judge.unlawful(), 0U) << judge.why();
  EXPECT_EQ(judge.commands(), 2U * 27 + 11);
}

TEST(CommandJudge, SeesEachLimitBroken) {
  const auto base = [](std::vector<test::SentTwist> sent) {
    CommandJudge judge;
    for (const test::SentTwist& s : sent) {
      judge.Take(s);
    }
    return judge.unlawful();
  };
  const auto at = [](int ms) { return Time{1ms * ms}; };
  EXPECT_EQ(base({{at(0), 30, 0}, {at(20), 60, 0}}), 1U);    // 0.06 m/s after 20 ms
  EXPECT_EQ(base({{at(0), 0, 0}, {at(2000), 0, 200}}), 1U);  // however long it stood
  EXPECT_EQ(base({{at(0), 30, 0}, {at(20), -50, 0}}), 1U);   // turned round
  EXPECT_EQ(base({{at(0), 30, 0}, {at(20), -10, 0}}), 0U);
  CommandJudge joint;
  Time now{};
  for (int u = 0; u <= 1'100'000; u += 100'000) {
    joint.Take(test::SentJoint{now += 10ms, 6, u});
  }
  EXPECT_EQ(joint.unlawful(), 1U);
  EXPECT_EQ(joint.why(), "axis 8: 1.100000 is too fast");
}

TEST(FaultRig, JudgesAWrongCommandWrong) {
  FaultRig rig(1);
  can::LoopbackBus::Port& other = *rig.bench().Attach(1);
  ASSERT_TRUE(rig.Ready());
  rig.Begin();
  can::Frame command{.id = 0x203, .dlc = 6, .data = {0x0F, 0, 0x60, 0xE3, 0x16, 0}};  // 1.5 rad/s
  ASSERT_EQ(other.Send(command), Status::kOk);
  EXPECT_EQ(rig.Conclude({}), Outcome::kWrong);
  EXPECT_EQ(rig.why(), "axis 4: 1.500000 is too fast");
}

TEST(FaultRig, JudgesByTheDevicesMotionAndTheBound) {
  FaultRig rig(2);
  const auto press = [&rig] {
    ASSERT_TRUE(rig.Ready());
    rig.Begin();
    rig.bench().devices().tracer().PressEmergencyStop(true);
    rig.script().At(rig.bench().now() + 100ms,
                    [&rig] { rig.bench().devices().tracer().PressEmergencyStop(false); });
  };
  press();
  EXPECT_EQ(rig.Conclude({.may_mask = false, .stays = true}), Outcome::kSafeStop) << rig.why();
  ASSERT_TRUE(rig.latency());
  EXPECT_LT(*rig.latency(), 50ms);
  press();
  EXPECT_EQ(rig.Conclude({.may_mask = false, .bound = 30ms}), Outcome::kLate);
  ASSERT_TRUE(rig.Ready());
  rig.Begin();  // no fault: it goes on
  EXPECT_EQ(rig.Conclude({.window = 50ms}), Outcome::kMasked) << rig.why();
  ASSERT_TRUE(rig.Ready());
  rig.Begin();
  EXPECT_EQ(rig.Conclude({.may_mask = false, .window = 50ms}), Outcome::kLate);
  // Re-armed by somebody before it may be: it moves again.
  press();
  const Time early = rig.bench().now() + 600ms;
  rig.script().At(early, [&rig] { EXPECT_EQ(rig.task().Rearm(), Status::kOk); });
  EXPECT_EQ(rig.Conclude({.may_mask = false, .stays = true, .window = 600ms, .hold = 3000ms}),
            Outcome::kWrong);
  EXPECT_EQ(rig.why(), "it moved again before it was re-armed");
}

TEST(Quantile, IsASmallestValueThatSuffices) {
  EXPECT_EQ(Quantile({}, 0.5), 0);
  EXPECT_EQ(Quantile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(Quantile({3, 1, 2}, 1), 3);
  EXPECT_EQ(Quantile({4, 3, 1, 2}, 0), 1);
}

/// A few of each kind that needs no other program; the bench has all.
TEST(FaultRows, EndWell) {
  for (const Row& row : Rows()) {
    if (std::string_view(row.id) == "F17" || std::string_view(row.id) == "F12") {
      continue;
    }
    SCOPED_TRACE(row.id);
    const Tally tally = row.run(14, 5);
    EXPECT_GE(tally.n(), 14U);
    EXPECT_EQ(tally.of(Outcome::kLate) + tally.of(Outcome::kWrong) + tally.of(Outcome::kCrash), 0U)
        << testing::PrintToString(tally.notes);
  }
}

}  // namespace
}  // namespace pipewright::bench
