// SPDX-License-Identifier: MIT
#include "hil/xarm/xarm_gateway.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "gateway_bench.h"

namespace pipewright::hil {
namespace {

class XarmGatewayBy : public testing::TestWithParam<XarmReportKind> {};

TEST_P(XarmGatewayBy, MovesTheArmAsTheHostCommandsAndSaysWhereItIs) {
  GatewayBench bench(Arm(), GetParam());
  Move(bench);
  EXPECT_LT((bench.driver.velocity_radps() - bench.qdot_radps).norm(), 1e-3);
  // A reading is a report (10 ms), a step and a SYNC (10 ms) old, at up to 0.3 rad/s.
  EXPECT_LT((bench.driver.position_rad() - bench.controller.position_rad()).cwiseAbs().maxCoeff(),
            0.3 * 0.025);
  bench.driver.Stop();
  bench.Run(1500);
  EXPECT_EQ(bench.driver.phase(), DriverPhase::kStopped);
  EXPECT_TRUE(bench.controller.velocity_radps().isZero(0));
  EXPECT_EQ(bench.controller.state(), xarm_state::kStopped) << "nobody else moves it by mistake";
  EXPECT_EQ(bench.gateway->phase(), XarmPhase::kIdle);
  const std::size_t heard = bench.controller.heard().size();
  bench.Run(1000);
  EXPECT_EQ(bench.Heard(XarmRegister::kJointVelocity, heard), 0);
  EXPECT_EQ(bench.gateway->counters().faults, 0U);
}

INSTANTIATE_TEST_SUITE_P(BothReports, XarmGatewayBy,
                         testing::Values(XarmReportKind::kReal, XarmReportKind::kRealTime));

TEST(XarmGateway, NoNodeBootsBeforeItsJointIsMeasured) {
  GatewayBench bench(Arm());
  bench.controller.SetSilent(true);
  bench.Run(800);
  for (const can::Frame& frame : bench.wire) {
    const int node = can::NodeOf(can::kHeartbeat.head, frame.id);
    EXPECT_TRUE(node < 1 || node > kXarmJoints) << "node " << node << " is there";
  }
  bench.controller.SetSilent(false);
  bench.Run(200);
  for (int i = 0; i < kXarmJoints; ++i) {
    EXPECT_EQ(bench.gateway->node(i).nmt(), NmtState::kPreOperational);
    const auto units =
        static_cast<std::int32_t>(bench.gateway->node(i).dictionary().Value(0x6064, 0));
    EXPECT_NEAR(units * 1e-6, Start()(i), 1e-6);
  }
}

TEST(XarmGateway, ANodeIsEnabledOnlyWhenAReportSaysThatTheArmIs) {
  GatewayBench bench(Arm());
  std::size_t reports_silent = 0;
  while (bench.now < Time(std::chrono::seconds(4)) && !bench.driver.ready()) {
    // The controller is enabled, and does not say so.
    const bool confirmed = bench.Heard(XarmRegister::kSetState) > 0;
    bench.controller.SetSilent(confirmed && reports_silent < 30);
    reports_silent += confirmed ? 1 : 0;
    bench.Tick();
    if (reports_silent < 30) {
      ASSERT_FALSE(bench.gateway->node(0).drive_state() == DriveState::kOperationEnabled);
    }
  }
  ASSERT_TRUE(bench.driver.ready()) << bench.gateway->trouble();
  const XarmRegister expected[] = {XarmRegister::kVersion,      XarmRegister::kGetError,
                                   XarmRegister::kGetError,     XarmRegister::kMotionEnable,
                                   XarmRegister::kSetMode,      XarmRegister::kSetState,
                                   XarmRegister::kJointVelocity};
  std::vector<XarmRegister> heard;
  for (const XarmFrame& frame : bench.controller.heard()) {
    if (frame.reg() != XarmRegister::kGetState) {
      heard.push_back(frame.reg());
    }
  }
  ASSERT_GE(heard.size(), std::size(expected));
  for (std::size_t i = 0; i < std::size(expected); ++i) {
    EXPECT_EQ(heard[i], expected[i]) << i;
  }
}

TEST(XarmGateway, EachCyclesTargetsAreOneRequestWithAnEnd) {
  GatewayBench bench(Arm());
  Move(bench);
  const std::size_t from = bench.controller.heard().size();
  bench.Run(500);
  EXPECT_NEAR(bench.Heard(XarmRegister::kJointVelocity, from), 50, 1);
  for (std::size_t i = from; i < bench.controller.heard().size(); ++i) {
    if (bench.controller.heard()[i].reg() != XarmRegister::kJointVelocity) {
      continue;
    }
    const Result<XarmVelocity> velocity = DecodeXarmVelocity(bench.controller.heard()[i]);
    ASSERT_TRUE(velocity.ok());
    EXPECT_NEAR(velocity->duration_s, 0.04, 1e-6);
    EXPECT_LT((velocity->velocity_radps - bench.qdot_radps).norm(), 1e-6);
  }
}

TEST(XarmGateway, WhenItDiesTheControllerStopsByItself) {
  GatewayBench bench(Arm());
  Move(bench);
  bench.gateway.reset();
  bench.Run(40 + 1 + 15);  // the request's end, a step, and 0.3 rad/s at 20 rad/s^2
  EXPECT_TRUE(bench.controller.velocity_radps().isZero(0));
}

TEST(XarmGateway, WhenItIsEndedItSaysSoToBothSides) {
  GatewayBench bench(Arm());
  Move(bench);
  const std::size_t from = bench.wire.size();
  bench.gateway->Stop(bench.now);
  bench.Run(17);  // 0.3 rad/s at 20 rad/s^2, and two steps
  EXPECT_TRUE(bench.controller.velocity_radps().isZero(0));
  EXPECT_EQ(bench.controller.state(), xarm_state::kStopped);
  for (int node = 1; node <= kXarmJoints; ++node) {
    EXPECT_EQ(bench.Emergencies(node, from), std::vector<std::uint32_t>{0x7500});
  }
  bench.Restart();
  bench.host_alive = false;
  bench.Run(300);
  bench.gateway->Stop(bench.now);  // at rest there is nothing to say
  EXPECT_EQ(bench.gateway->phase(), XarmPhase::kIdle);
}

TEST(XarmGateway, WhenTheHostDiesTheArmIsBroughtToRestAndThenLeftAlone) {
  GatewayBench bench(Arm());
  Move(bench);
  const std::size_t from = bench.wire.size();
  bench.host_alive = false;
  bench.Run(600);
  for (int node = 1; node <= kXarmJoints; ++node) {
    const std::vector<std::uint32_t> said = bench.Emergencies(node, from);
    ASSERT_FALSE(said.empty());
    EXPECT_EQ(said[0], can::emergency::kPdoLost);
  }
  EXPECT_TRUE(bench.controller.velocity_radps().isZero(0));
  const std::size_t heard = bench.controller.heard().size();
  bench.Run(1000);
  EXPECT_EQ(bench.Heard(XarmRegister::kJointVelocity, heard), 0);
  EXPECT_EQ(bench.controller.state(), xarm_state::kStopped);
  bench.host_alive = true;
  ExpectRecovery(bench);
}

TEST(XarmGateway, AControllerThatCannotDoItIsRefusedForGood) {
  const struct {
    const char* version;
    XarmReportKind report;
    const char* why;  ///< empty: taken
  } cases[] = {{"6,9,XI1303,AC1303,v2.5.0", XarmReportKind::kReal, "6 axes"},
               {"7,7,XI1303,AC1303,v1.7.9", XarmReportKind::kReal, "firmware 1.7.9"},
               {"7,7,XI1303,AC1303,v1.8.0", XarmReportKind::kReal, ""},
               {"7,7,XI1303,AC1303,v2.0.9", XarmReportKind::kRealTime, "30000"},
               {"7,7,XI1303,AC1303,v2.1.0", XarmReportKind::kRealTime, ""},
               {"Schunk", XarmReportKind::kReal, "cannot be read"}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.version);
    GatewayBench bench({.version = c.version}, c.report);
    bench.host_alive = false;
    bench.Run(1500);
    const bool taken = std::string(c.why).empty();
    EXPECT_EQ(bench.gateway->phase(), taken ? XarmPhase::kIdle : XarmPhase::kRefused);
    EXPECT_NE(bench.gateway->trouble().find(c.why), std::string::npos) << bench.gateway->trouble();
    EXPECT_EQ(bench.wire.empty(), !taken) << "no node boots";
  }
}

TEST(XarmGateway, PiecesAndSlowAnswersAreNoMatter) {
  const struct {
    const char* what;
    std::size_t bytes_per_step;
    int steps_per_send;
    Duration delay;
  } cases[] = {{"in pieces of 13 bytes", 13, 1, {}},
               {"three reports at a time", 0, 30, {}},
               {"answers after 30 ms", 0, 1, std::chrono::milliseconds(30)}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    XarmControllerConfig arm = Arm();
    arm.bytes_per_step = c.bytes_per_step;
    arm.steps_per_send = c.steps_per_send;
    arm.answer_delay = c.delay;
    GatewayBench bench(arm);
    Move(bench);
    bench.Run(500);
    EXPECT_TRUE(bench.driver.ready());
    EXPECT_EQ(bench.gateway->counters().faults, 0U);
  }
}

TEST(XarmGateway, SlowsDownBeforeItsLimits) {
  for (const double speed_radps : {3.1, -3.1}) {
    GatewayBench bench(Arm());
    bench.config.lower_rad.setConstant(-1.2);
    bench.config.upper_rad.setConstant(1.0);
    bench.Restart();
    ASSERT_TRUE(bench.BeReady());
    bench.qdot_radps.setConstant(speed_radps);
    for (int i = 0; i < 3000; ++i) {
      bench.Tick();
      ASSERT_LT(bench.controller.position_rad().maxCoeff(), 1.0 + 0.01);
      ASSERT_GT(bench.controller.position_rad().minCoeff(), -1.2 - 0.01);
    }
    EXPECT_TRUE(bench.driver.ready());
    const double edge = speed_radps > 0 ? 1.0 : -1.2;
    EXPECT_LT((bench.controller.position_rad().array() - edge).abs().maxCoeff(), 0.02);
  }
}

TEST(XarmGateway, NoRequestIsFasterThanAJoint) {
  GatewayBench bench(Arm());
  ASSERT_TRUE(bench.BeReady());
  can::LoopbackBus::Port& other = *bench.bus.Attach();
  const auto from = bench.controller.heard().size();
  bench.host_alive = false;
  for (int i = 0; i < 5; ++i) {  // 20 rad/s: no driver of ours would say so
    ASSERT_EQ(other.Send({.id = 0x203, .dlc = 6, .data = {0x0F, 0, 0x00, 0x2D, 0x31, 0x01}}),
              Status::kOk);
    ASSERT_EQ(other.Send({.id = 0x080, .dlc = 0}), Status::kOk);
    bench.Run(10);
  }
  double fastest = 0;
  for (std::size_t i = from; i < bench.controller.heard().size(); ++i) {
    const Result<XarmVelocity> velocity = DecodeXarmVelocity(bench.controller.heard()[i]);
    fastest = velocity.ok() ? std::max(fastest, velocity->velocity_radps.maxCoeff()) : fastest;
  }
  EXPECT_NEAR(fastest, kXarmSpeedLimit_radps, 1e-6);
}

}  // namespace
}  // namespace pipewright::hil
