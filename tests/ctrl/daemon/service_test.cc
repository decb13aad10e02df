// SPDX-License-Identifier: MIT
// The service with its threads, systemd's socket and operators, over emulated devices.
#include "ctrl/daemon/service.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "tests/ctrl/daemon/robot_bench.h"
#include "tests/support/command.h"

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

class ServiceTest : public testing::Test {
 protected:
  ServiceTest() {
    hil::ScenarioResult loaded = hil::LoadScenario("pipes1");
    loaded.scenario->camera.rate_hz = 4;  // a frame takes its time under a sanitizer
    bench_ = std::make_unique<test::RobotBench>(*loaded.scenario, base_, arm_);
    wires_ = std::make_unique<test::ThreadedWires>(base_, arm_);
    config_.base_can = "test0";
    config_.arm_can = "test1";
    config_.site = *loaded.scenario;
    config_.ask_realtime = false;  // no test may starve its neighbours
    config_.require_realtime = false;
    config_.task_bound = 3s;
    config_.socket = folder_ / "s";
    EXPECT_EQ(server_.Open(config_.socket), Status::kOk) << server_.error_text();

    systemd_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = folder_ / "n";
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(bind(systemd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    notify_ = std::make_unique<ServiceNotify>(path, 400ms);
  }
  ~ServiceTest() override {
    wires_->hung = false;
    service_.reset();
    bench_->Stop();
    close(systemd_);
  }

  void Begin() {
    service_ = std::make_unique<RobotService>(config_, *wires_, *bench_, *notify_, server_, latch_,
                                              RealtimeGrant{EPERM, EPERM, 0});
    service_->Begin(Now());
    bench_->Start();
  }

  /// Turns of the service until `done`, at most `limit`. Notes what systemd was told.
  bool Until(const std::function<bool()>& done, Duration limit = 20s) {
    const Time end = Now() + limit;
    while (!done() && Now() < end) {
      gone_ = !service_->Step(Now(), ask_to_end_) || gone_;
      ask_to_end_ = false;
      Hear();
      SleepUntil(Now() + RobotService::kPeriod);
    }
    return done();
  }
  bool Until(ServiceState state) {
    return Until([&] { return service_->state() == state; });
  }
  void Turn() {
    Until([] { return false; }, 30ms);
  }
  void Hear() {
    char bytes[512];
    for (ssize_t size = 0; (size = recv(systemd_, bytes, sizeof bytes, 0)) > 0;) {
      const std::string word(bytes, static_cast<std::size_t>(size));
      strokes_ += word == "WATCHDOG=1" ? 1 : 0;
      told_ += word + "\n";
    }
  }
  nlohmann::json Ask(const std::string& request) {
    char out[LineServer::kAnswerBytes];
    const std::size_t size = service_->Answer(request, {}, out);
    return nlohmann::json::parse(std::string(out, size), nullptr, false);
  }
  /// Until the robot has been told where to go, on a machine that keeps up with it.
  bool RunsAndMoves() {
    return Until([&] {
      const nlohmann::json run = Ask("status")["run"];
      return run["phase"] == "running" && run["mission"] != "start";
    });
  }
  /// Devices or cycles were so late that a device was rightly held to be lost.
  bool TooBusy() {
    return bench_->late_max() > 30ms || Ask("status")["run"]["latency_max_us"] > 30e3;
  }
  /// Whether the test is over and skipped: what went wrong may be the machine's doing.
  bool SkippedFor(bool wrong) {
    if (!wrong || !TooBusy()) {
      return false;
    }
    const auto skip = [] { GTEST_SKIP() << "too busy a machine: devices or cycles were late"; };
    skip();  // GTEST_SKIP is a return without a value
    return true;
  }
  bool LostADevice() { return Ask("status")["run"]["phase"] == "fault"; }

  const std::filesystem::path folder_ = test::TestFolder();
  ThreadedBus base_;
  ThreadedBus arm_;
  DaemonConfig config_;
  std::unique_ptr<test::RobotBench> bench_;
  std::unique_ptr<test::ThreadedWires> wires_;
  LineServer server_;
  LatchFile latch_{folder_ / "latch"};
  int systemd_ = -1;
  std::unique_ptr<ServiceNotify> notify_;
  std::unique_ptr<RobotService> service_;
  bool ask_to_end_ = false;
  bool gone_ = false;
  int strokes_ = 0;
  std::string told_;
};

TEST_F(ServiceTest, ListensWithoutAWordOnTheBusUntilItIsStarted) {
  Begin();
  EXPECT_TRUE(Until([&] { return Ask("status")["base"]["heard"] == true; }));
  const nlohmann::json status = Ask("status");
  EXPECT_EQ(status["state"], "idle");
  EXPECT_GT(status["base"]["battery_V"].get<double>(), 10);
  EXPECT_EQ(status["base"]["emergency_stop"], false);
  EXPECT_EQ(status["realtime"]["fifo"], false);
  EXPECT_EQ(status["bus"]["arm"], "test1");
  EXPECT_TRUE(Until([&] { return Ask("status")["camera"]["frames"].get<int>() > 0; }));
  EXPECT_EQ(wires_->sent, 0);
  EXPECT_TRUE(Until([&] { return strokes_ >= 2; }));
  EXPECT_NE(told_.find("READY=1"), std::string::npos);
  EXPECT_NE(told_.find("STATUS=idle"), std::string::npos);
}

TEST_F(ServiceTest, RunsStopsRearmsRunsAgainAndEndsAtRestWhenAskedTo) {
  Begin();
  ASSERT_TRUE(Until(ServiceState::kIdle));
  EXPECT_EQ(Ask("start")["ok"], true);
  const bool moved = RunsAndMoves();
  if (SkippedFor(!moved)) {
    return;
  }
  ASSERT_TRUE(moved) << Ask("status");
  EXPECT_EQ(latch_.Read(), "a run was under way when the service last ended");
  strokes_ = 0;
  EXPECT_TRUE(Until([&] { return strokes_ >= 3; }));  // all three tasks answer

  EXPECT_EQ(Ask("estop")["ok"], true);
  ASSERT_TRUE(Until(ServiceState::kEmergencyStop)) << Ask("status");
  if (SkippedFor(LostADevice())) {
    return;
  }
  EXPECT_EQ(Ask("status")["run"]["phase"], "stopped") << Ask("status");
  EXPECT_EQ(latch_.Read(), "emergency stop by an operator");
  EXPECT_EQ(Ask("start")["error"], "latched: re-arm first");
  const int sent = wires_->sent;
  Turn();
  EXPECT_EQ(wires_->sent, sent);  // and silence

  EXPECT_EQ(Ask("rearm")["ok"], true);
  ASSERT_TRUE(Until(ServiceState::kIdle));
  EXPECT_EQ(latch_.Read(), "");
  EXPECT_EQ(Ask("start")["ok"], true);
  const bool again = RunsAndMoves();
  if (SkippedFor(!again)) {
    return;
  }
  ASSERT_TRUE(again) << Ask("status");
  EXPECT_EQ(Ask("status")["run"]["number"], 2);

  ask_to_end_ = true;
  ASSERT_TRUE(Until([&] { return gone_; }));
  if (SkippedFor(LostADevice())) {
    return;
  }
  EXPECT_EQ(Ask("status")["run"]["phase"], "stopped") << Ask("status");
  EXPECT_NE(told_.find("STOPPING=1"), std::string::npos);
  EXPECT_EQ(latch_.Read(), "");
}

TEST_F(ServiceTest, ATaskThatHangsStopsTheStrokesAndTheRobotsProgram) {
  config_.task_bound = 1s;
  config_.camera_timeout = 10s;  // frames without a pose must not be told first
  Begin();
  ASSERT_TRUE(Until(ServiceState::kIdle));
  EXPECT_EQ(Ask("start")["ok"], true);
  const bool moved = RunsAndMoves();
  if (SkippedFor(!moved)) {
    return;
  }
  ASSERT_TRUE(moved) << Ask("status");
  wires_->hung = true;
  ASSERT_TRUE(Until(ServiceState::kStopping));
  EXPECT_EQ(service_->reason(), "control does not answer");
  strokes_ = 0;
  Until([] { return false; }, 1200ms);  // three of systemd's periods
  EXPECT_EQ(strokes_, 0);
  EXPECT_EQ(Ask("status")["state"], "stopping");  // operators still have their answer
  EXPECT_EQ(latch_.Read(), "a run was under way when the service last ended");

  wires_->hung = false;
  EXPECT_TRUE(Until(ServiceState::kEnded)) << Ask("status");
}

TEST_F(ServiceTest, AProcessThatARunDidNotOutliveBeginsLatched) {
  ASSERT_EQ(latch_.Set("a run was under way when the service last ended"), Status::kOk);
  config_.autostart = true;
  Begin();
  Turn();
  EXPECT_EQ(service_->state(), ServiceState::kEmergencyStop);
  EXPECT_EQ(Ask("status")["reason"], "a run was under way when the service last ended");
  EXPECT_EQ(wires_->sent, 0);
}

TEST_F(ServiceTest, WithoutABusItSaysSoAndStartsNothing) {
  wires_->plugged = false;
  config_.autostart = true;
  Begin();
  Turn();
  EXPECT_EQ(service_->state(), ServiceState::kNoBus);
  EXPECT_EQ(Ask("start")["ok"], false);
  EXPECT_EQ(Ask("status")["bus"]["error"], "test0: ?unplugged?");  // and is JSON all the same
  EXPECT_EQ(wires_->sent, 0);
  ask_to_end_ = true;
  EXPECT_TRUE(Until([&] { return gone_; }, 1s));
}

TEST_F(ServiceTest, DevicesThatAreNotThereEndTheRunInWords) {
  for (const int device : {0, 1, 2, 3, 4, 5, 6, 7}) {
    bench_->devices().Silence(device, Time{});
  }
  Begin();
  ASSERT_TRUE(Until(ServiceState::kIdle));
  EXPECT_EQ(Ask("start")["ok"], true);
  ASSERT_TRUE(Until(ServiceState::kEnded));
  EXPECT_NE(service_->reason().find("device_fault: base: not heard on the bus"),
            std::string_view::npos)
      << service_->reason();
}

TEST_F(ServiceTest, WhatIsNoRequestIsAnError) {
  Begin();
  for (const std::string& line : {std::string(), std::string("START"), std::string("status "),
                                  std::string("{\"command\":\"start\"}"), std::string(100, '\0')}) {
    const nlohmann::json answer = Ask(line);
    EXPECT_EQ(answer["ok"], false) << line;
    EXPECT_EQ(answer["error"], "not a request: status, start, stop, estop, rearm");
  }
}

}  // namespace
}  // namespace pipewright
