// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "ctrl/daemon/config.h"
#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

/// The shortest decimal that reads back as the same number; TOML takes an integer for one too.
std::string Real(double value) { return fmt::format("{}", value); }

std::string Array(const double* values, int count) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    text += (i > 0 ? ", " : "") + Real(values[i]);
  }
  return "[" + text + "]";
}

std::string CameraText(const DaemonConfig& c) {
  const CameraChoice& camera = c.camera;
  std::string text;
  if (camera.source == CameraSource::kV4l2) {
    const CameraIntrinsics& i = camera.intrinsics;
    text = fmt::format(
        "source = \"v4l2\"\ndevice = \"{}\"\nwidth = {}\nheight = {}\nfx = {}\nfy = {}\ncx = {}\n"
        "cy = {}\nz_min_m = {}\nz_max_m = {}\nstamp_offset_ms = {}\n",
        camera.path, i.width, i.height, Real(i.fx), Real(i.fy), Real(i.cx), Real(i.cy),
        Real(i.z_min_m), Real(i.z_max_m), Real(1e3 * ToSeconds(camera.stamp_offset)));
  } else {
    text = fmt::format("source = \"stream\"\nsocket = \"{}\"\n", camera.path);
  }
  return text + fmt::format("stride = {}\ntimeout_s = {}\n", camera.stride,
                            Real(ToSeconds(c.camera_timeout)));
}

std::string SiteText(const Site& site) {
  const ArmVector home_rad = HomeJoints(TracerUf7());
  const StartPose& start = site.start;
  return fmt::format(
      "[workspace]\nmin_m = {}\nmax_m = {}\n\n[map]\nlo_m = {}\nhi_m = {}\n\n"
      "[start]\nx_m = {}\ny_m = {}\nyaw_rad = {}\njoints_rad = {}\nclearance_m = {}\n",
      Array(site.workspace.min_m.data(), 3), Array(site.workspace.max_m.data(), 3),
      Array(site.map.min_m.data(), 3), Array(site.map.max_m.data(), 3), Real(start.x_m),
      Real(start.y_m), Real(start.yaw_rad),
      Array(start.joints_rad.empty() ? home_rad.data() : start.joints_rad.data(), kArmJoints),
      Real(start.clearance_m));
}

}  // namespace

std::string DaemonConfigText(const DaemonConfig& c) {
  return fmt::format("[can]\nbase = \"{}\"\narm = \"{}\"\n\n", c.base_can, c.arm_can) +
         fmt::format("[base]\nmode_codes = \"{}\"\n\n", c.base_modes) +
         fmt::format("[control]\nrate_hz = {}\nalpha = {}\n\n", Real(c.rate_hz), Real(c.alpha)) +
         fmt::format("[realtime]\nenabled = {}\nrequired = {}\npriority = {}\ncpu = {}\n\n",
                     c.ask_realtime, c.require_realtime, c.realtime.priority, c.realtime.cpu) +
         "[camera]\n" + CameraText(c) + "\n" + SiteText(c.site) +
         fmt::format(
             "\n[mission]\nplanner = \"{}\"\nseed = {}\ntime_limit_s = {}\nautostart = {}\n\n",
             c.planner == PlannerKind::kCfnbv ? "cfnbv" : "cfnbv_paper", c.seed,
             Real(c.time_limit_s), c.autostart) +
         fmt::format("[watchdog]\ntasks_s = {}\nplanning_s = {}\n\n", Real(ToSeconds(c.task_bound)),
                     Real(ToSeconds(c.planning_bound))) +
         fmt::format("[service]\nsocket = \"{}\"\n", c.socket);
}

}  // namespace pipewright
