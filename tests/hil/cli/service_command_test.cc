// SPDX-License-Identifier: MIT
// pipewright status and its like against a pipewrightd process without a bus, and what answers
// wrongly.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "platform/linux/clock.h"
#include "platform/linux/line_server.h"
#include "tests/support/command_json.h"

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

constexpr const char* kConfig =
    "[can]\nbase = \"nosuchcan9\"\n[realtime]\nenabled = false\n[camera]\nsource = \"stream\"\n"
    "socket = \"/nowhere/depth.sock\"\n[workspace]\nmin_m = [0.1, 0.1, 0.1]\n"
    "max_m = [1.4, 1.4, 1.4]\n[start]\nx_m = 0.35\ny_m = 0.75\nyaw_rad = 0.0\n[service]\n";

class ServiceCommandTest : public testing::Test {
 protected:
  ~ServiceCommandTest() override { End(SIGKILL); }

  test::CommandResult Run(const std::string& word) {
    return test::RunCommand(PIPEWRIGHT_BINARY, word + " --socket s", folder_);
  }

  /// pipewrightd in the test's folder, once it answers.
  void StartDaemon() {
    test::WriteFile(folder_ / "c.toml",
                    kConfig + ("socket = \"" + (folder_ / "s").string()) + "\"\n");
    daemon_ = fork();
    if (daemon_ == 0) {
      setenv("STATE_DIRECTORY", folder_.c_str(), 1);
      execl(PIPEWRIGHTD_BINARY, "pipewrightd", "--config", (folder_ / "c.toml").c_str(), nullptr);
      _exit(127);
    }
    const Time end = Now() + 20s;
    while (Run("status").exit_code != 0 && Now() < end) {
      SleepUntil(Now() + 10ms);
    }
  }
  /// @returns the exit code; -1: it was killed
  int End(int signal) {
    if (daemon_ <= 0) {
      return -1;
    }
    kill(daemon_, signal);
    int status = 0;
    waitpid(daemon_, &status, 0);
    daemon_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  const std::filesystem::path folder_ = test::TestFolder();
  pid_t daemon_ = -1;
};

TEST_F(ServiceCommandTest, TalksToADaemonAndEndsItBySigterm) {
  StartDaemon();
  const nlohmann::json status = test::Parsed(Run("status --json"));
  EXPECT_EQ(status["state"], "no_bus");
  EXPECT_EQ(status["bus"]["error"].get<std::string>().find("nosuchcan9: "), 0U) << status;
  const test::CommandResult table = Run("status");
  EXPECT_NE(table.out.find("state     no_bus"), std::string::npos) << table.out;

  const test::CommandResult start = Run("start");
  EXPECT_EQ(start.exit_code, 1);
  EXPECT_EQ(start.error, "pipewright: start refused: there is no bus to the robot\n");
  EXPECT_EQ(Run("estop").exit_code, 0);
  EXPECT_EQ(test::Parsed(Run("status --json"))["state"], "emergency_stop");
  EXPECT_EQ(End(SIGTERM), 0);
  EXPECT_EQ(Run("status").exit_code, 2);
}

TEST_F(ServiceCommandTest, AnEmergencyStopOutlivesTheProcess) {
  StartDaemon();
  EXPECT_EQ(Run("estop").exit_code, 0);
  SleepUntil(Now() + 50ms);
  EXPECT_EQ(End(SIGKILL), -1);
  StartDaemon();
  const nlohmann::json status = test::Parsed(Run("status --json"));
  EXPECT_EQ(status["state"], "emergency_stop");
  EXPECT_EQ(status["reason"], "emergency stop by an operator");
  EXPECT_EQ(Run("rearm").exit_code, 0);
  EXPECT_EQ(End(SIGTERM), 0);
  StartDaemon();
  EXPECT_EQ(test::Parsed(Run("status --json"))["state"], "no_bus");
}

TEST_F(ServiceCommandTest, ASecondDaemonDoesNotTakeTheFirstOnesSocket) {
  StartDaemon();
  const test::CommandResult second =
      test::RunCommand(PIPEWRIGHTD_BINARY, "--config c.toml", folder_);
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_NE(second.error.find("another process answers there"), std::string::npos);
  EXPECT_EQ(Run("status").exit_code, 0);
}

TEST_F(ServiceCommandTest, NobodyThereIsBadInput) {
  const test::CommandResult result = Run("status");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.error, "pipewright: s: No such file or directory; is pipewrightd running?\n");
}

TEST_F(ServiceCommandTest, WhatIsNotPipewrightdIsTold) {
  for (const std::string& answer : {std::string("hello"), std::string("[1]"), std::string("{}"),
                                    std::string("{\"ok\":1}"), std::string("{\"ok\":true}")}) {
    LineServer server;
    ASSERT_EQ(server.Open(folder_ / "s"), Status::kOk);
    std::atomic<bool> quit = false;
    std::thread serving([&] {
      while (!quit) {
        server.Poll(Now(), [&](std::string_view, const Peer&, std::span<char> out) {
          return answer.copy(out.data(), out.size());
        });
        SleepUntil(Now() + 1ms);
      }
    });
    EXPECT_EQ(Run("status").exit_code, 2) << answer;
    quit = true;
    serving.join();
  }
}

}  // namespace
}  // namespace pipewright
