// SPDX-License-Identifier: MIT
#include "hil/cli/report_page.h"

#include "hil/report/report.h"
#include "hil/report/world_view.h"
#include "platform/robot/uf7.h"

namespace pipewright::hil {

RunLimits LimitsOf(const RobotProgramConfig& config) {
  RunLimits limits;
  limits.base_mps = TracerUf7().base.speed_mps;
  limits.base_radps = TracerUf7().base.turn_radps;
  limits.joint_radps = JointValues(TracerUf7(), &ArmJoint::speed_radps).minCoeff();
  limits.reached = config.control.law.reached;
  limits.period_us = 1e6 * config.control.law.constraints.period_s;
  return limits;
}

CycleSample CycleSampleOf(const ControlReport& report, const Clearance* truth, double cycle_us) {
  CycleSample sample;
  if (truth != nullptr) {
    sample.true_plane_m = truth->plane.distance_m;
    sample.true_pipe_m = truth->pipe.distance_m;
    sample.true_self_m = truth->self.distance_m;
  }
  const Clearances& seen = report.stats.clearance;
  sample.seen_plane_m = seen.plane_m;
  sample.seen_pipe_m = seen.pipe_m;
  sample.seen_self_m = seen.self_m;
  sample.seen_obstacle_m = seen.obstacle_m;
  sample.task_error = report.progress.id != 0 ? report.progress.error : kNoReading;
  sample.base_mps = report.sent(0);
  sample.base_radps = report.sent(1);
  for (int i = 0; i < kArmJoints; ++i) {
    sample.joint_radps[static_cast<std::size_t>(i)] = report.sent(2 + i);
  }
  sample.rows = report.stats.rows;
  sample.qp_iterations = report.stats.qp.iterations;
  sample.qp_us = 1e-3 * static_cast<double>(report.stats.qp_ns);
  sample.cycle_us = cycle_us;
  return sample;
}

MapSample MapSampleOf(const VoxelGrid& map, const Emulator& emulator, double base_load,
                      double arm_load) {
  MapSample sample;
  sample.coverage_ratio = emulator.truth().coverage().ratio;
  sample.free = map.counts().free;
  sample.occupied = map.counts().occupied;
  sample.unknown = map.counts().unknown;
  sample.covered = map.counts().covered;
  sample.visual_entropy = map.visual_entropy();
  sample.coverage_entropy = map.coverage_entropy();
  sample.base_bus_load = base_load;
  sample.arm_bus_load = arm_load;
  sample.p_WP = emulator.plant().p_WP();
  return sample;
}

std::string ReportPage(const nlohmann::ordered_json& run, const nlohmann::ordered_json& plan,
                       const RunRecorder& recorder, const Scenario& scenario, const Truth* truth) {
  ReportInput input;
  input.run = run;
  input.plan = plan;
  input.plots = recorder.Plots();
  input.world = ViewOf(scenario, truth);
  input.world.hand_path = recorder.hand_path();
  return RenderReport(input);
}

}  // namespace pipewright::hil
