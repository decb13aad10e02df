// SPDX-License-Identifier: MIT
#include "ctrl/daemon/config.h"

#include <gtest/gtest.h>

#include "platform/robot/uf7.h"
#include "tests/support/command.h"

namespace pipewright {
namespace {

// Line by line, so that a test can replace one and know its number.
const std::vector<std::string> kLines = {
    "[can]",                       // 1
    "base = \"can0\"",             // 2
    "arm = \"can1\"",              // 3
    "[base]",                      // 4
    "mode_codes = \"sdk\"",        // 5
    "[control]",                   // 6
    "rate_hz = 200",               // 7
    "alpha = 0.8",                 // 8
    "[realtime]",                  // 9
    "required = true",             // 10
    "priority = 70",               // 11
    "cpu = 3",                     // 12
    "[camera]",                    // 13
    "source = \"v4l2\"",           // 14
    "device = \"/dev/video2\"",    // 15
    "width = 424",                 // 16
    "height = 240",                // 17
    "fx = 223.4",                  // 18
    "fy = 223.4",                  // 19
    "cx = 211.5",                  // 20
    "cy = 119.5",                  // 21
    "z_min_m = 0.168",             // 22
    "z_max_m = 6.0",               // 23
    "stamp_offset_ms = -8.5",      // 24
    "stride = 4",                  // 25
    "timeout_s = 1.5",             // 26
    "[workspace]",                 // 27
    "min_m = [0.1, 0.1, 0.1]",     // 28
    "max_m = [1.4, 1.4, 1.4]",     // 29
    "[start]",                     // 30
    "x_m = 0.35",                  // 31
    "y_m = 0.75",                  // 32
    "yaw_rad = 0.25",              // 33
    "clearance_m = 0.2",           // 34
    "[mission]",                   // 35
    "planner = \"cfnbv\"",         // 36
    "seed = 7",                    // 37
    "time_limit_s = 600",          // 38
    "autostart = true",            // 39
    "[watchdog]",                  // 40
    "tasks_s = 2",                 // 41
    "planning_s = 20",             // 42
    "[service]",                   // 43
    "socket = \"/run/x/s.sock\"",  // 44
};

std::string Text(int line = 0, const std::string& instead = "") {
  std::string text;
  for (int i = 1; const std::string& one : kLines) {
    text += (i++ == line ? instead : one) + "\n";
  }
  return text;
}

TEST(DaemonConfig, ReadsEveryKey) {
  const DaemonConfigResult result = ParseDaemonConfig(Text(), "c.toml");
  ASSERT_TRUE(result.config) << result.errors.front();
  const DaemonConfig& c = *result.config;
  EXPECT_EQ(c.base_can, "can0");
  EXPECT_EQ(c.arm_can, "can1");
  EXPECT_FALSE(c.shared_bus());
  EXPECT_EQ(c.rate_hz, 200);
  EXPECT_EQ(c.alpha, 0.8);
  EXPECT_TRUE(c.require_realtime);
  EXPECT_EQ(c.realtime.priority, 70);
  EXPECT_EQ(c.realtime.cpu, 3);
  EXPECT_EQ(c.camera.source, CameraSource::kV4l2);
  EXPECT_EQ(c.camera.path, "/dev/video2");
  EXPECT_EQ(c.camera.intrinsics.width, 424);
  EXPECT_EQ(c.camera.intrinsics.cy, 119.5);
  EXPECT_EQ(c.camera.stamp_offset, -std::chrono::microseconds(8500));
  EXPECT_EQ(c.camera_timeout, std::chrono::milliseconds(1500));
  EXPECT_EQ(c.site.start.yaw_rad, 0.25);
  EXPECT_EQ(c.site.map.max_m, Vector3d(1.9, 1.9, 1.9));
  EXPECT_TRUE(c.autostart);
  EXPECT_EQ(c.task_bound, std::chrono::seconds(2));
  EXPECT_EQ(c.planning_bound, std::chrono::seconds(20));
  EXPECT_EQ(c.socket, "/run/x/s.sock");

  const RobotProgramConfig program = ProgramConfigOf(c);
  EXPECT_EQ(program.control.law.constraints.period_s, 0.005);
  EXPECT_EQ(program.control.arm.cycle_ms, 5);
  EXPECT_EQ(program.control.start.phi_rad, 0.25);
  EXPECT_EQ(program.mapping.start_clearance_m, 0.2);
  EXPECT_EQ(program.mapping.cloud.stride, 4);
  EXPECT_EQ(program.mission.seed, 7U);
  EXPECT_EQ(program.mission.mission_timeout, std::chrono::seconds(600));
  EXPECT_EQ(program.start_joints_rad, HomeJoints(TracerUf7()));
}

TEST(DaemonConfig, NamesTheLineAndTheKeyOfWhatIsWrong) {
  const struct {
    int line;
    const char* instead;
    const char* error;
  } cases[] = {
      {2, "", "c.toml:1:1: can.base: missing"},
      {2, "base = 0", "c.toml:2:8: can.base: must be text"},
      {2, "base = \"sixteen_letters_\"", "c.toml:2:8: can.base: must be 1 to 15"},
      {2, "base = \"can\\\"0\"", "c.toml:2:8: can.base: must be 1 to 15 visible"},
      {3, "arm = \"\"", "c.toml:3:7: can.arm: must be 1 to 15"},
      {3, "bus = \"x\"", "c.toml:3:1: can.bus: unknown key"},
      {5, "mode_codes = \"bunker\"", "c.toml:5:14: base.mode_codes: must be one of sdk, tracer12"},
      {7, "rate_hz = 300", "c.toml:7:11: control.rate_hz: a period of 3.33333 ms"},
      {7, "rate_hz = nan", "c.toml:7:11: control.rate_hz: must be within [50, 1000]"},
      {8, "alpha = 1", "c.toml:8:9: control.alpha: must be within"},
      {10, "required = 1", "c.toml:10:12: realtime.required: must be true or false"},
      {11, "enabled = false", "c.toml:10:12: realtime.required: cannot be had without"},
      {11, "priority = 100", "c.toml:11:12: realtime.priority: must be within [1, 99]"},
      {12, "cpu = 1.5", "c.toml:12:7: realtime.cpu: must be an integer"},
      {14, "source = \"usb\"", "c.toml:14:10: camera.source: must be v4l2 or stream"},
      {14, "source = \"stream\"", "c.toml:15:1: camera.device: unknown key"},
      {15, "device = \"video2\"", "c.toml:15:10: camera.device: must be an absolute path"},
      {18, "", "c.toml:13:1: camera.fx: missing"},
      {20, "cx = 424.5", "c.toml:20:6: camera.cx: must be within [0, 424]"},
      {21, "cy = 240.5", "c.toml:21:6: camera.cy: must be within [0, 240]"},
      {34, "joints_rad = [0, -0.9, 0, 5.0, 0, -0.4, 0]",
       "c.toml:30:1: start.joints_rad: joint 4 at 5.000000 is beyond its limits"},
      {16, "width = 849", "c.toml:16:9: camera.width: must be within [16, 848]"},
      {23, "z_max_m = 0.15", "c.toml:23:11: camera.z_max_m: must be greater than z_min_m"},
      {25, "stride = 0", "c.toml:25:10: camera.stride: must be within [1, 16]"},
      {29, "max_m = [0.1, 1.4, 1.4]", "c.toml:29:9: workspace.max_m: must be greater than min_m"},
      {27, "", "workspace: missing"},
      {34, "clearance_m = -1", "c.toml:34:15: start.clearance_m: must be within [0, 2]"},
      {36, "planner = \"best\"", "c.toml:36:11: mission.planner: must be cfnbv or cfnbv_paper"},
      {38, "time_limit_s = 0", "c.toml:38:16: mission.time_limit_s: must be within"},
      {42, "planning_s = 1e9", "c.toml:42:14: watchdog.planning_s: must be within [0.1, 300]"},
      {44, "socket = \"run.sock\"", "c.toml:44:10: service.socket: must be an absolute path"},
      {44, "socket = ", "c.toml:44:"},
  };
  for (const auto& c : cases) {
    const DaemonConfigResult result = ParseDaemonConfig(Text(c.line, c.instead), "c.toml");
    EXPECT_FALSE(result.config) << c.instead;
    std::string all;
    for (const std::string& error : result.errors) {
      all += error + "\n";
    }
    EXPECT_NE(all.find(c.error), std::string::npos) << c.error << "\nin\n" << all;
  }
}

TEST(DaemonConfig, TellsAllErrorsAtOnce) {
  const DaemonConfigResult result = ParseDaemonConfig("[can]\nbase = 1\n[x]\n[camera]\n", "c");
  EXPECT_GE(result.errors.size(), 5U);  // base, source, workspace, start, x
}

TEST(DaemonConfig, OneBusForBothCarriesLess) {
  EXPECT_TRUE(ParseDaemonConfig(Text(3, ""), "c").errors.front().find("at most 125 Hz") !=
              std::string::npos);
}

TEST(DaemonConfig, ALargePictureMustBeThinnedEnough) {
  std::string text = Text(25, "stride = 1");
  text.replace(text.find("width = 424"), 11, "width = 848");
  text.replace(text.find("height = 240"), 12, "height = 480");
  const DaemonConfigResult result = ParseDaemonConfig(text, "c");
  ASSERT_EQ(result.errors.size(), 1U);
  EXPECT_NE(result.errors[0].find("camera.stride: leaves more pixels than can be used"),
            std::string::npos);
}

TEST(DaemonConfig, WhatItPrintsIsTheSameConfiguration) {
  const std::string stream =
      "[can]\nbase = \"vcan0\"\n[camera]\nsource = \"stream\"\nsocket = \"/tmp/s\"\n[workspace]\n"
      "min_m = [0.1, 0.1, 0.1]\nmax_m = [1.4, 1.4, 1.4]\n[start]\nx_m = 0.35\ny_m = 0.75\n"
      "yaw_rad = 0.333333333333333\n";
  for (const std::string& text : {Text(), stream}) {
    const DaemonConfigResult first = ParseDaemonConfig(text, "first");
    ASSERT_TRUE(first.config) << first.errors.front();
    const std::string printed = DaemonConfigText(*first.config);
    const DaemonConfigResult second = ParseDaemonConfig(printed, "second");
    ASSERT_TRUE(second.config) << second.errors.front() << "\n" << printed;
    EXPECT_EQ(DaemonConfigText(*second.config), printed);
    EXPECT_EQ(second.config->site.start.yaw_rad, first.config->site.start.yaw_rad);
    EXPECT_EQ(second.config->camera.path, first.config->camera.path);
    EXPECT_EQ(second.config->camera.stamp_offset, first.config->camera.stamp_offset);
    EXPECT_EQ(second.config->rate_hz, first.config->rate_hz);
  }
}

TEST(DaemonConfig, TheShippedOneIsSound) {
  const DaemonConfigResult result = LoadDaemonConfig(PIPEWRIGHTD_TOML);
  EXPECT_TRUE(result.config) << result.errors.front();
}

TEST(DaemonConfig, AFileThatIsNotThereIsNamed) {
  const DaemonConfigResult result = LoadDaemonConfig("/nowhere/c.toml");
  ASSERT_EQ(result.errors.size(), 1U);
  EXPECT_EQ(result.errors[0], "/nowhere/c.toml: cannot be read");
}

TEST(DaemonCommand, ChecksAndPrintsAConfiguration) {
  const std::filesystem::path folder = test::TestFolder();
  test::WriteFile(folder / "good.toml", Text());
  test::WriteFile(folder / "bad.toml", Text(7, "rate_hz = 300"));
  const auto run = [&](const std::string& arguments) {
    return test::RunCommand(PIPEWRIGHTD_BINARY, arguments, folder);
  };
  EXPECT_EQ(run("--config good.toml --check").exit_code, 0);
  EXPECT_EQ(run("--config good.toml --check").error, "");
  const test::CommandResult printed = run("--config good.toml --print-config");
  EXPECT_EQ(printed.out, DaemonConfigText(*ParseDaemonConfig(Text(), "c").config));
  const test::CommandResult bad = run("--config bad.toml --check");
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_EQ(bad.error.find("pipewrightd: bad.toml:7:11: control.rate_hz: "), 0U) << bad.error;
  EXPECT_EQ(run("--config bad.toml").exit_code, 2);  // and it does not start
  EXPECT_EQ(run("--no-such-option").exit_code, 2);
  EXPECT_EQ(run("--help").exit_code, 0);
}

}  // namespace
}  // namespace pipewright
