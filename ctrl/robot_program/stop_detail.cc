// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/stop_detail.h"

#include <fmt/format.h>

namespace pipewright {
namespace {

std::string FaultText(const char* device, const DeviceFault& fault) {
  if (fault.problem == Problem::kNone) {
    return "";
  }
  const std::string name = fault.node > 0 ? fmt::format("{} joint {}", device, fault.node) : device;
  return fmt::format("{}: {}{}", name, Name(fault.problem),
                     fault.detail != 0 ? fmt::format(" (0x{:X})", fault.detail) : "");
}

/// Why a mission whose devices are well did not complete.
std::string Reason(const MissionOutput& mission) {
  const PlanNumbers& n = mission.numbers;
  switch (mission.stop) {
    case StopReason::kNoReachableView:
      return fmt::format(
          "no view that would show or cover more can be reached from here; left: {} unknown voxels "
          "at the border of the known, {} surface voxels not covered",
          n.unknown_targets, n.uncovered_targets);
    case StopReason::kStuck:
      return "goal after goal stalled, and nothing new was seen or covered";
    case StopReason::kTimeout:
      return "the time limit came first";
    case StopReason::kDeviceFault:
      return "the devices were not ready in time";
    case StopReason::kPoseLost:
      return "the base moved otherwise than its wheels tell, and scans did not find it again";
    case StopReason::kNone:
      return "interrupted";
    case StopReason::kComplete:
      break;
  }
  return "";
}

}  // namespace

std::string StopDetail(const MissionOutput& mission, const ControlReport& report,
                       bool camera_lost) {
  if (mission.stop == StopReason::kComplete) {
    return "";
  }
  std::string text;
  const auto add = [&text](const std::string& what) {
    text += (text.empty() || what.empty() ? "" : "; ") + what;
  };
  add(FaultText("base", report.base_fault));
  add(FaultText("arm", report.arm_fault));
  add(camera_lost ? "camera: sends no frame that can be used" : "");
  if (text.empty()) {
    add(Reason(mission));
  }
  return text;
}

}  // namespace pipewright
