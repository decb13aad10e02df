// SPDX-License-Identifier: MIT
// What stops the arm, and what it takes to go on.
#include <gtest/gtest.h>

#include <limits>

#include "gateway_bench.h"
#include "hil/xarm/xarm_gateway.h"

namespace pipewright::hil {
namespace {

TEST(XarmGateway, ReportsThatStayAwayAreALostLink) {
  GatewayBench bench(Arm());
  Move(bench);
  const std::size_t from = bench.wire.size();
  bench.controller.SetSilent(true);
  bench.Run(45);
  EXPECT_TRUE(bench.driver.ready());
  const std::size_t heard = bench.controller.heard().size();
  bench.Run(100);  // and the drives' ramps have ended
  ExpectFault(bench, xarm_emergency::kLinkLost, from);
  EXPECT_EQ(bench.vendor, static_cast<std::uint32_t>(XarmProblem::kSilent));
  EXPECT_TRUE(bench.controller.velocity_radps().isZero(0));
  const XarmFrame last = bench.controller.heard().back();
  ASSERT_TRUE(DecodeXarmVelocity(last).ok());
  EXPECT_TRUE(DecodeXarmVelocity(last)->velocity_radps.isZero(0)) << "told to stop, too";
  EXPECT_LE(bench.controller.heard().size() - heard, 3U);

  bench.controller.SetSilent(false);
  const std::size_t before = bench.controller.heard().size();
  bench.Run(2000);
  EXPECT_EQ(bench.controller.heard().size(), before) << "without the host's word, nothing";
  ExpectRecovery(bench);
}

TEST(XarmGateway, ALostConnectionAtWorkIsNotMendedWithoutTheHostsWord) {
  GatewayBench bench(Arm());
  Move(bench);
  const std::size_t from = bench.wire.size();
  bench.controller.Drop();
  bench.Run(200);
  ExpectFault(bench, xarm_emergency::kLinkLost, from);
  EXPECT_EQ(bench.vendor, static_cast<std::uint32_t>(XarmProblem::kClosed));
  bench.Run(3000);
  EXPECT_EQ(bench.controller.clients(), 0);
  EXPECT_EQ(bench.gateway->counters().connections, 1U);
  ExpectRecovery(bench);
}

TEST(XarmGateway, AResetThatFoundNobodyCleansNoLaterError) {
  GatewayBench bench(Arm());
  Move(bench);
  bench.controller.SetDeaf(true);
  bench.Run(300);
  bench.driver.Reset();
  bench.Run(4500);  // the driver gave up; the gateway goes on trying to connect
  ASSERT_EQ(bench.driver.phase(), DriverPhase::kFault);
  bench.controller.InjectError(19);
  bench.controller.SetDeaf(false);
  bench.Run(1500);
  EXPECT_EQ(bench.gateway->phase(), XarmPhase::kFaulted);
  EXPECT_EQ(bench.controller.error(), 19);
  ExpectRecovery(bench);
}

TEST(XarmGateway, ALostConnectionAtRestIsMendedByItself) {
  GatewayBench bench(Arm());
  bench.host_alive = false;
  bench.Run(300);
  ASSERT_EQ(bench.gateway->phase(), XarmPhase::kIdle);
  bench.controller.Drop();
  bench.Run(50);
  EXPECT_TRUE(bench.All(DriveState::kFault));
  bench.Run(1500);
  EXPECT_EQ(bench.gateway->phase(), XarmPhase::kIdle);
  bench.host_alive = true;
  EXPECT_TRUE(bench.BeReady());
}

TEST(XarmGateway, AnswersThatStayAwayAreALostLink) {
  GatewayBench bench(Arm());
  Move(bench);
  const std::size_t from = bench.wire.size();
  bench.controller.SetDeaf(true);
  bench.Run(300);
  ExpectFault(bench, xarm_emergency::kLinkLost, from);
  EXPECT_EQ(bench.vendor, static_cast<std::uint32_t>(XarmProblem::kNoAnswer));
  EXPECT_TRUE(bench.controller.velocity_radps().isZero(0));
  bench.controller.SetDeaf(false);
  ExpectRecovery(bench);
}

TEST(XarmGateway, APersonWhoTakesTheArmKeepsIt) {
  const struct {
    const char* what;
    int mode, state;
  } cases[] = {{"teach mode", xarm_mode::kTeach, xarm_state::kSleeping},
               {"the stop button", xarm_mode::kJointVelocity, xarm_state::kStopped},
               {"a pause", xarm_mode::kJointVelocity, xarm_state::kPaused},
               {"another client's mode", xarm_mode::kPosition, xarm_state::kReset}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    GatewayBench bench(Arm());
    Move(bench);
    const std::size_t from = bench.wire.size();
    const std::size_t before = bench.controller.heard().size();
    bench.controller.TakeOver(c.mode, c.state);
    bench.Run(300);
    ExpectFault(bench, xarm_emergency::kTakenOver, from);
    // While the joints come to rest, a state that lets them move is told as moving.
    EXPECT_EQ(bench.vendor >> 8, static_cast<std::uint32_t>(c.mode));
    EXPECT_EQ(xarm_state::Moves(static_cast<int>(bench.vendor & 0xFF)), xarm_state::Moves(c.state));
    EXPECT_LE(bench.Heard(XarmRegister::kJointVelocity, before), 2) << "those under way";
    EXPECT_EQ(bench.Heard(XarmRegister::kGetError, before), 1);
    const std::size_t silent = bench.controller.heard().size();
    bench.Run(3000);
    EXPECT_EQ(bench.controller.heard().size(), silent);
    EXPECT_EQ(bench.controller.mode(), c.mode);
    ExpectRecovery(bench);
  }
}

TEST(XarmGateway, AnErrorOfTheControllerIsToldWithItsCodeAndCleanedAtAReset) {
  GatewayBench bench(Arm());
  Move(bench);
  const std::size_t from = bench.wire.size();
  const std::size_t before = bench.controller.heard().size();
  bench.controller.InjectError(31);  // abnormal current: a collision
  bench.Run(300);
  ExpectFault(bench, xarm_emergency::kControllerError, from);
  EXPECT_EQ(bench.vendor, 31U);
  EXPECT_EQ(bench.Heard(XarmRegister::kCleanError, before), 0) << "that is the host's to ask for";
  ExpectRecovery(bench);
  EXPECT_EQ(bench.Heard(XarmRegister::kCleanError, before), 1);
}

TEST(XarmGateway, AnErrorThatStaysIsToldAgainAtEachReset) {
  GatewayBench bench(Arm());
  Move(bench);
  bench.controller.SetStickyError(2);  // the emergency stop is pressed
  bench.Run(300);
  const std::size_t from = bench.wire.size();
  bench.driver.Reset();
  bench.Run(2000);
  EXPECT_FALSE(bench.driver.ready());
  EXPECT_FALSE(bench.Emergencies(1, from).empty());
  EXPECT_TRUE(bench.All(DriveState::kFault));
  EXPECT_FALSE(bench.controller.enabled() && bench.controller.error() == 0);
  bench.controller.SetStickyError(0);
  bench.Run(2000);
  ExpectRecovery(bench);
}

TEST(XarmGateway, AnErrorFromBeforeIsThereWhenTheNodesAre) {
  GatewayBench bench(Arm());
  bench.host_alive = false;
  bench.controller.InjectError(19);
  bench.Run(300);
  ExpectFault(bench, xarm_emergency::kControllerError, 0);
  EXPECT_EQ(bench.vendor, 19U);
  EXPECT_EQ(bench.Heard(XarmRegister::kCleanError), 0);
  bench.host_alive = true;
  EXPECT_TRUE(bench.BeReady()) << "the driver's first reset is the operator's start";
}

TEST(XarmGateway, WhatNoArmCanDoIsNoReport) {
  GatewayBench bench(Arm());
  Move(bench);
  const std::size_t from = bench.wire.size();
  XarmVector wild = Start();
  wild(4) = std::numeric_limits<double>::quiet_NaN();
  bench.controller.SetReported(wild);
  bench.Run(200);
  ExpectFault(bench, xarm_emergency::kLinkLost, from);
  EXPECT_GT(bench.gateway->client().bad_reports(), 3U);
}

}  // namespace
}  // namespace pipewright::hil
