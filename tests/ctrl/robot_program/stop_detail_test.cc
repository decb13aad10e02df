// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/stop_detail.h"

#include <gtest/gtest.h>

namespace pipewright {
namespace {

TEST(StopDetail, NamesTheDeviceAndItsProblem) {
  MissionOutput mission;
  mission.stop = StopReason::kDeviceFault;
  ControlReport report;
  EXPECT_EQ(StopDetail(mission, report, true), "camera: sends no frame that can be used");
  report.arm_fault = {Status::kFault, Problem::kDriveFault, 3, 0x8130};
  EXPECT_EQ(StopDetail(mission, report, false), "arm joint 3: drive fault (0x8130)");
  report.base_fault = {Status::kTimeout, Problem::kStateStale, 0, 0};
  EXPECT_EQ(
      StopDetail(mission, report, true),
      "base: no longer reports its state; arm joint 3: drive fault (0x8130); camera: sends no "
      "frame that can be used");
  mission.stop = StopReason::kComplete;
  EXPECT_EQ(StopDetail(mission, report, true), "");
}

}  // namespace
}  // namespace pipewright
