// SPDX-License-Identifier: MIT
#include "ctrl/daemon/service_report.h"

#include <algorithm>
#include <cinttypes>
#include <cstdio>

namespace pipewright {
namespace {

const char* Bool(bool value) { return value ? "true" : "false"; }

struct Text {
  std::string_view text;

  int size() const { return static_cast<int>(text.size()); }
  const char* data() const { return text.data(); }
};

/// What snprintf says it would have written, cut to what it has.
std::size_t Written(int size, std::span<char> out) {
  return size < 0 || out.empty() ? 0 : std::min(static_cast<std::size_t>(size), out.size() - 1);
}

}  // namespace

const char* Name(ControlPhase phase) {
  switch (phase) {
    case ControlPhase::kStarting:
      return "starting";
    case ControlPhase::kRunning:
      return "running";
    case ControlPhase::kStopping:
      return "stopping";
    case ControlPhase::kStopped:
      return "stopped";
    case ControlPhase::kFault:
      return "fault";
  }
  return "?";
}

std::size_t ReportJson(const ServiceReport& r, std::span<char> out) {
  const auto us = [](Duration d) { return 1e6 * ToSeconds(d); };
  const Text reason{r.reason}, base{r.base_can}, arm{r.arm_can}, bus{r.bus_error},
      camera{r.camera_error};
  const int size = std::snprintf(
      out.data(), out.size(),
      "{\"ok\":true,\"state\":\"%s\",\"reason\":\"%.*s\",\"latched\":%s,\"uptime_s\":%.1f,"
      "\"bus\":{\"base\":\"%.*s\",\"arm\":\"%.*s\",\"error\":\"%.*s\"},"
      "\"base\":{\"heard\":%s,\"battery_V\":%.1f,\"emergency_stop\":%s},\"arm\":{\"heard\":%s},"
      "\"camera\":{\"frames\":%" PRIu64
      ",\"error\":\"%.*s\"},"
      "\"realtime\":{\"fifo\":%s,\"memory_locked\":%s},"
      "\"run\":{\"number\":%" PRIu64
      ",\"time_s\":%.1f,\"phase\":\"%s\",\"mission\":\"%s\","
      "\"stop\":\"%s\",\"plans\":%d,\"goals_reached\":%d,\"x_m\":%.3f,\"y_m\":%.3f,"
      "\"phi_rad\":%.3f,\"cycles\":%" PRIu64 ",\"missed\":%" PRIu64
      ",\"latency_max_us\":%.1f,\"cycle_max_us\":%.1f,"
      "\"voxels\":{\"total\":%d,\"free\":%d,\"occupied\":%d,\"unknown\":%d,\"covered\":%d}}}",
      Name(r.state), reason.size(), reason.data(), Bool(r.latched), r.uptime_s, base.size(),
      base.data(), arm.size(), arm.data(), bus.size(), bus.data(), Bool(r.base_heard), r.battery_V,
      Bool(r.base_emergency_stop), Bool(r.arm_heard), r.camera_frames, camera.size(), camera.data(),
      Bool(r.fifo), Bool(r.memory_locked), r.runs, r.run_s, Name(r.phase), Name(r.mission),
      Name(r.stop), r.plan_steps, r.goals_reached, r.pose.x(), r.pose.y(), r.pose.z(),
      r.cycles.cycles, r.cycles.missed, us(r.cycles.worst_latency), us(r.worst_cycle),
      r.counts.total, r.counts.free, r.counts.occupied, r.counts.unknown, r.counts.covered);
  return Written(size, out);
}

std::size_t AnswerJson(std::string_view error, std::span<char> out) {
  const int size = error.empty()
                       ? std::snprintf(out.data(), out.size(), "{\"ok\":true}")
                       : std::snprintf(out.data(), out.size(), "{\"ok\":false,\"error\":\"%.*s\"}",
                                       static_cast<int>(error.size()), error.data());
  return Written(size, out);
}

}  // namespace pipewright
