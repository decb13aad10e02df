// SPDX-License-Identifier: MIT
// The threads, the clock and the emulator together, on buses within the process.
#include "hil/cli/realtime_run.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "hil/cli/can_interfaces.h"
#include "tests/support/threaded_bus.h"

namespace pipewright::hil {
namespace {

using std::chrono_literals::operator""s;

class RealtimeRunTest : public testing::Test {
 protected:
  RealtimeRunTest() {
    options_.scenario = "pipes1";
    options_.ask_fifo = false;  // no test may starve its neighbours
    folder_path_ = std::filesystem::temp_directory_path() /
                   ("pipewright_realtime_" + std::to_string(getpid()));
    std::filesystem::remove_all(folder_path_);
  }
  ~RealtimeRunTest() override { std::filesystem::remove_all(folder_path_); }

  /// Ends the run two seconds after the robot has begun to move, at the latest after 20 s.
  RunHooks Hooks() {
    RunHooks hooks;
    hooks.progress = [this](const RunProgress& p) {
      if (p.state == MissionState::kLookAround || p.state == MissionState::kMove) {
        moving_since_ = moving_since_.value_or(p.now);
      }
      enough_ = p.now > Time{20s} || (moving_since_ && p.now - *moving_since_ >= 2s);
    };
    hooks.interrupted = [this] { return enough_; };
    return hooks;
  }

  nlohmann::ordered_json Run(const RealtimePorts& ports) {
    ScenarioResult loaded = LoadScenario(options_.scenario);
    loaded.scenario->camera.rate_hz = 4;  // a frame takes its time under a sanitizer
    RunFolder folder;
    EXPECT_EQ(folder.Open(folder_path_, {{"stop_reason", "running"}}), "");
    nlohmann::ordered_json run = RunRealtime(ports, *loaded.scenario, options_, folder, Hooks());
    EXPECT_EQ(folder.Close(), "");
    return run;
  }

  /// Whether this machine was too busy to be on time, and devices were rightly held to be lost.
  static bool Starved(const nlohmann::ordered_json& run) {
    const nlohmann::ordered_json& realtime = run["realtime"];
    return run["stop_reason"] == "device_fault" &&
           (realtime["emulator_late_max_ms"].get<double>() > 30 ||
            realtime["latency_max_us"].get<double>() > 30e3);
  }

  int Lines(const char* file) const {
    std::ifstream in(folder_path_ / file);
    int lines = 0;
    for (std::string line; std::getline(in, line); ++lines) {
      last_line_ = line;
    }
    return lines;
  }
  /// Of the last line that Lines() read.
  std::string Column(int column) const {
    std::size_t from = 0;
    for (int i = 0; i < column; ++i) {
      from = last_line_.find(',', from) + 1;
    }
    return last_line_.substr(from, last_line_.find(',', from) - from);
  }

  InspectionOptions options_;
  std::filesystem::path folder_path_;
  std::optional<Time> moving_since_;
  bool enough_ = false;
  mutable std::string last_line_;
};

TEST_F(RealtimeRunTest, OnASharedBusTheRobotComesUpMovesAndStops) {
  options_.bus = "vcan0";
  ThreadedBus bus;
  RealtimePorts ports;
  ports.base = ports.arm = bus.Attach();
  ports.devices = {bus.Attach()};
  ports.taps = {{bus.Attach(), "vcan0"}};
  const nlohmann::ordered_json run = Run(ports);
  if (Starved(run)) {
    GTEST_SKIP() << "too busy a machine: " << run["realtime"];
  }
  EXPECT_TRUE(moving_since_.has_value()) << run["stop_detail"];
  EXPECT_GT(run["path"]["joint_rad"].get<double>(), 0.01);
  EXPECT_EQ(run["contacts"], 0);
  EXPECT_EQ(run["can"]["dropped"], 0);
  EXPECT_EQ(run["control"]["heap_allocations"], 0);
  EXPECT_EQ(run["realtime"]["trace_lost"], 0);
  // One line a cycle, and the head; at the end the robot was at rest and disabled.
  EXPECT_EQ(Lines("trace.csv"), run["control"]["cycles"].get<int>() + 1);
  EXPECT_EQ(Column(1), std::to_string(static_cast<int>(ControlPhase::kStopped))) << last_line_;
  EXPECT_TRUE(std::filesystem::exists(folder_path_ / "report.html"));
  EXPECT_TRUE(std::filesystem::exists(folder_path_ / "map.bt"));
  // All that the robot said and heard is in the log; the devices' last words may be there besides.
  EXPECT_GE(Lines("can.log"), run["can"]["tx"].get<int>() + run["can"]["rx"].get<int>());
}

TEST_F(RealtimeRunTest, OnTwoBusesEachDeviceIsOnItsOwn) {
  options_.bus = "vcan0,vcan1";
  options_.rate_hz = 200;
  ThreadedBus base;
  ThreadedBus arm;
  RealtimePorts ports;
  ports.base = base.Attach();
  ports.arm = arm.Attach();
  ports.devices = {base.Attach(), arm.Attach()};
  ports.taps = {{base.Attach(), "vcan0"}, {arm.Attach(), "vcan1"}};
  const nlohmann::ordered_json run = Run(ports);
  if (Starved(run)) {
    GTEST_SKIP() << "too busy a machine: " << run["realtime"];
  }
  EXPECT_TRUE(moving_since_.has_value()) << run["stop_detail"];
  EXPECT_GT(run["path"]["joint_rad"].get<double>(), 0.01);
  EXPECT_EQ(run["can"]["dropped"], 0);
}

TEST_F(RealtimeRunTest, ABusWithoutDevicesIsADeviceFault) {
  options_.bus = "vcan0";
  ThreadedBus bus;
  RealtimePorts ports;
  ports.base = ports.arm = bus.Attach();
  ports.taps = {{bus.Attach(), "vcan0"}};
  const nlohmann::ordered_json run = Run(ports);
  EXPECT_EQ(run["stop_reason"], "device_fault");
  EXPECT_NE(run["stop_detail"].get<std::string>().find("base"), std::string::npos);
  EXPECT_EQ(run["realtime"]["devices"], "elsewhere");
  EXPECT_TRUE(run["contacts"].is_null());
  EXPECT_FALSE(Passed(run));
}

TEST(CanInterfaces, NamesTheInterfaceThatItCannotOpenAndWhy) {
  CanInterfaces interfaces;
  const std::string error = interfaces.Open({"nosuchcan9"}, true);
  EXPECT_NE(error.find("--bus nosuchcan9: "), std::string::npos) << error;
  EXPECT_GT(error.size(), std::string("--bus nosuchcan9: cannot open the interface: ").size());
}

}  // namespace
}  // namespace pipewright::hil
