// SPDX-License-Identifier: MIT
// The emulated controller, by a client that is told what to say.
#include "hil/xarm/xarm_controller.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "hil/xarm/xarm_client.h"

namespace pipewright::hil {
namespace {

using std::chrono::milliseconds;

struct Bench {
  Bench() {
    EXPECT_EQ(controller.Open(), "");
    client = XarmClient({.address = "127.0.0.1",
                         .request_port = controller.request_port(),
                         .report = XarmReportKind::kRealTime,
                         .report_port = controller.report_port(XarmReportKind::kRealTime)});
    client.Connect(now);
    for (int i = 0; i < 50000 && !(client.up() && controller.clients() == 2); ++i) {
      client.Step(now);
      controller.Step(now);
      usleep(100);
    }
  }
  void Tick() {
    now += milliseconds(1);
    client.Step(now);
    controller.Step(now);
    XarmReport next;
    while (client.TakeReport(next)) {
      report = next;
    }
  }
  void Run(int ms) {
    for (int i = 0; i < ms; ++i) {
      Tick();
    }
  }
  /// The state byte of the answer; time stands while it is under way.
  int Ask(const XarmFrame& request) {
    EXPECT_EQ(client.Ask(request, now), Status::kOk);
    for (int i = 0; i < 50000; ++i) {
      controller.Step(now);
      client.Step(now);
      if (client.TakeAnswer(answer)) {
        return answer.data[0];
      }
      usleep(100);
    }
    ADD_FAILURE() << "no answer";
    return -1;
  }
  int Turn(double speed_radps, double duration_s) {
    return Ask(*XarmVelocityRequest(
        {.velocity_radps = XarmVector::Constant(speed_radps), .duration_s = duration_s}));
  }
  void BeReady() {
    ASSERT_EQ(Ask(XarmMotionEnable(true)) & xarm_status::kError, 0);
    Ask(XarmSetMode(xarm_mode::kJointVelocity));
    ASSERT_EQ(Ask(XarmSetState(xarm_state::kReady)), 0);
  }

  XarmController controller;
  XarmClient client{XarmClientConfig{}};
  XarmFrame answer;
  XarmReport report;
  Time now{};
};

TEST(XarmController, MovesOnlyWhenEnabledInItsModeAndReady) {
  Bench bench;
  EXPECT_EQ(bench.Turn(0.5, 0.1), xarm_status::kCannotMove);
  bench.BeReady();
  EXPECT_EQ(bench.Turn(0.5, 0.1), 0);
  bench.Run(50);
  EXPECT_DOUBLE_EQ(bench.controller.velocity_radps()(3), 0.5);
  EXPECT_EQ(bench.controller.state(), xarm_state::kMoving);
  bench.Ask(XarmSetMode(xarm_mode::kPosition));  // takes the state back
  bench.Run(50);
  EXPECT_TRUE(bench.controller.velocity_radps().isZero(0));
  EXPECT_EQ(bench.Turn(0.5, 0.1), xarm_status::kCannotMove);
  bench.Ask(XarmSetState(xarm_state::kReady));
  EXPECT_EQ(bench.Turn(0.5, 0.1), xarm_status::kCannotMove) << "position mode";
}

TEST(XarmController, AVelocityEndsWhenItsTimeIsOver) {
  Bench bench;
  bench.BeReady();
  bench.Turn(0.4, 0.04);
  bench.Run(39);
  EXPECT_FLOAT_EQ(static_cast<float>(bench.controller.velocity_radps()(0)), 0.4F);
  bench.Run(1 + 20);  // 0.4 rad/s at 20 rad/s^2
  EXPECT_NEAR(bench.controller.velocity_radps()(0), 0, 1e-9);
  const double there_rad = bench.controller.position_rad()(0);
  bench.Run(100);
  EXPECT_NEAR(bench.controller.position_rad()(0), there_rad, 1e-9);
  // The way: 20 ms up, 20 ms at speed, 20 ms down; a step more or less.
  EXPECT_NEAR(there_rad, 0.4 * 0.04, 0.4 * 0.002);
}

TEST(XarmController, AnErrorStopsItUntilItIsCleanedAndTheStateSet) {
  Bench bench;
  bench.BeReady();
  bench.Turn(0.4, 1);
  bench.Run(50);
  bench.controller.InjectError(31);
  bench.Run(50);
  EXPECT_TRUE(bench.controller.velocity_radps().isZero(1e-12));
  EXPECT_EQ(bench.Turn(0.4, 1), xarm_status::kError | xarm_status::kCannotMove);
  bench.Ask(XarmAsk(XarmRegister::kGetError));
  EXPECT_EQ(DecodeXarmErrors(bench.answer)->error, 31);
  EXPECT_EQ(bench.Ask(XarmSetState(xarm_state::kReady)),
            xarm_status::kError | xarm_status::kCannotMove);
  EXPECT_EQ(bench.Ask(XarmAsk(XarmRegister::kCleanError)), xarm_status::kCannotMove);
  EXPECT_EQ(bench.Ask(XarmSetState(xarm_state::kReady)), 0);
  EXPECT_EQ(bench.Turn(0.4, 1), 0);
}

TEST(XarmController, AJointAtItsEndIsAnError) {
  Bench bench;
  bench.BeReady();
  for (int i = 0; i < 30; ++i) {
    bench.Turn(3.0, 0.5);
    bench.Run(100);
  }
  EXPECT_EQ(bench.controller.error(), 23);
  EXPECT_LE(bench.controller.position_rad().maxCoeff(), 6.28);
}

// As xArm-Python-SDK 1.18.5 speaks to firmware 2.5.0: protocol 3, a mode of two bytes, and of the
// version no byte that no zero follows.
TEST(XarmController, TakesWhatTheVendorsClientSays) {
  XarmController controller;
  ASSERT_EQ(controller.Open(), "");
  TcpStream client;
  ASSERT_EQ(client.Connect("127.0.0.1", controller.request_port()), Status::kOk);
  const auto hear = [&](std::size_t bytes) {
    for (int i = 0; i < 50000 && client.received().size() < bytes; ++i) {
      controller.Step(Time{});
      client.Poll();
      usleep(100);
    }
    std::vector<std::uint8_t> heard(client.received().begin(), client.received().end());
    client.Take(heard.size());
    return heard;
  };
  hear(0);
  for (int i = 0; i < 50000 && !client.open(); ++i) {
    client.Poll();
    usleep(100);
  }
  const std::uint8_t set_mode[] = {0, 7, 0, 3, 0, 3, 19, 4, 0};
  ASSERT_TRUE(client.Send(set_mode));
  EXPECT_EQ(hear(8), (std::vector<std::uint8_t>{0, 7, 0, 3, 0, 2, 19, xarm_status::kCannotMove}));
  EXPECT_EQ(controller.mode(), xarm_mode::kJointVelocity);
  const std::uint8_t version[] = {0, 8, 0, 2, 0, 1, 1};
  ASSERT_TRUE(client.Send(version));
  const std::vector<std::uint8_t> heard = hear(48);
  ASSERT_EQ(heard.size(), 48U);
  EXPECT_EQ(std::string(heard.begin() + 8, heard.end()).find("v2.5.0"), 18U);
  EXPECT_EQ(heard.back(), 0);
  const std::uint8_t heartbeat[] = {0, 0, 0, 1, 0, 2, 0, 0};
  const std::uint8_t state[] = {0, 9, 0, 3, 0, 1, 13};
  ASSERT_TRUE(client.Send(heartbeat) && client.Send(state));
  EXPECT_EQ(hear(9)[1], 9) << "the heartbeat has no answer";
}

TEST(XarmController, ReportsWhereItIs) {
  Bench bench;
  bench.BeReady();
  bench.Turn(0.4, 1);
  bench.Run(300);
  for (int i = 0; i < 1000 && bench.report.velocity_radps(0) < 0.39; ++i) {
    usleep(1000);
    bench.client.Step(bench.now);
    XarmReport next;
    while (bench.client.TakeReport(next)) {
      bench.report = next;
    }
  }
  EXPECT_EQ(bench.report.mode, xarm_mode::kJointVelocity);
  EXPECT_EQ(bench.report.state, xarm_state::kMoving);
  EXPECT_NEAR(bench.report.velocity_radps(0), 0.4, 1e-6);
  EXPECT_GT(bench.report.position_rad(0), 0.0);
}

}  // namespace
}  // namespace pipewright::hil
