// SPDX-License-Identifier: MIT
#include "hil/cli/replay_run.h"

#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "ctrl/robot_program/stop_detail.h"
#include "hil/cli/program_loop.h"
#include "hil/cli/run_figures.h"
#include "hil/cli/virtual_run.h"
#include "platform/robot/uf7.h"

namespace pipewright::hil {
namespace {

using std::chrono_literals::operator""s;
using WallClock = std::chrono::steady_clock;

/// The frames of a depth recording at the instants at which the program got them.
class RecordedCamera {
 public:
  explicit RecordedCamera(DepthReader* depth)
      : depth_(depth), next_(std::make_unique<DepthFrame>()) {
    Advance();
  }

  bool Give(Time now, DepthFrame& frame) {
    if (!has_next_ || next_given_ > now) {
      return false;
    }
    frame = *next_;
    last_given_ = next_given_;
    Advance();
    return true;
  }

  /// Whether it can no longer be told what the camera gave at `now`.
  bool Unknown(Time now) const {
    return depth_ != nullptr && !has_next_ && !depth_->end().empty() && now > last_given_;
  }

 private:
  void Advance() { has_next_ = depth_ != nullptr && depth_->Next(*next_, next_given_); }

  DepthReader* depth_;
  std::unique_ptr<DepthFrame> next_;
  Time next_given_{};
  Time last_given_{Duration{-1}};
  bool has_next_ = false;
};

class Replay final : public ProgramPeer {
 public:
  explicit Replay(const ReplayInput& input)
      : input_(input),
        program_(std::make_unique<RobotProgram>(input.program.config(), TracerUf7())),
        loop_(*program_, FromSeconds(1 / input.program.options.rate_hz), *this),
        camera_(input.depth) {}

  nlohmann::ordered_json Run();

 private:
  void AdvanceTo(Time now) override { input_.bus.AdvanceTo(now); }
  Port& base() override { return input_.bus; }
  Port& arm() override { return input_.bus; }
  bool See(Time now, DepthFrame& frame) override { return camera_.Give(now, frame); }
  bool StopAsked(Time now) override {
    return input_.program.interrupted && now >= *input_.program.interrupted;
  }
  void OnControl(const ControlReport& report, std::chrono::nanoseconds took,
                 std::uint64_t allocations) override;
  void OnPlan(Time now, const PlanningTask& planning, std::chrono::nanoseconds took) override;
  void ShowProgress(Time now);
  nlohmann::ordered_json Figures(Time end, double wall_s) const;

  const ReplayInput& input_;
  std::unique_ptr<RobotProgram> program_;
  ProgramLoop loop_;
  RecordedCamera camera_;
  RunFigures figures_;
  Time next_progress_{};
};

void Replay::OnControl(const ControlReport& report, std::chrono::nanoseconds took, std::uint64_t) {
  figures_.Add(report);
  figures_.cycle_us.push_back(static_cast<float>(1e6 * ToSeconds(took)));
}

void Replay::OnPlan(Time, const PlanningTask&, std::chrono::nanoseconds took) {
  figures_.step_ms.push_back(static_cast<float>(1e3 * ToSeconds(took)));
}

void Replay::ShowProgress(Time now) {
  if (now < next_progress_ || !input_.progress) {
    return;
  }
  next_progress_ = now + Duration{1s};
  input_.progress({now, program_->planning().output().state, program_->mapping().map().counts(),
                   input_.bus.comparison().differences()});
}

nlohmann::ordered_json Replay::Figures(Time end, double wall_s) const {
  const MissionOutput& mission = program_->planning().output();
  const ControlReport& report = program_->control().report();
  const VoxelGrid& map = program_->mapping().map();
  const MapCounts& counts = map.counts();
  const bool over = mission.state == MissionState::kDone || mission.state == MissionState::kFault;
  return {{"replayed_s", ToSeconds(end)},
          {"wall_time_s", wall_s},
          {"state", Name(mission.state)},
          {"stop_reason", Name(mission.stop)},
          {"stop_detail", over ? StopDetail(mission, report, program_->camera_lost()) : ""},
          {"cycles", figures_.cycles},
          {"plan_steps", mission.plan_steps},
          {"depth_frames", program_->mapping().counters().frames},
          {"voxels",
           {{"total", counts.total},
            {"free", counts.free},
            {"occupied", counts.occupied},
            {"unknown", counts.unknown},
            {"residual", counts.residual},
            {"covered", counts.covered}}},
          {"cycle_us",
           {{"p50", Percentile(figures_.cycle_us, 0.5)},
            {"p99", Percentile(figures_.cycle_us, 0.99)},
            {"max", Percentile(figures_.cycle_us, 1)}}}};
}

nlohmann::ordered_json Replay::Run() {
  const WallClock::time_point start = WallClock::now();
  Time now{};
  for (AdvanceTo(now); !input_.bus.AtEnd() && !camera_.Unknown(now); AdvanceTo(now)) {
    loop_.Tick(now);
    ShowProgress(now);
    now += ProgramLoop::kTick;
    if (input_.speed > 0) {
      std::this_thread::sleep_until(start + FromSeconds(ToSeconds(now) / input_.speed));
    }
  }
  input_.bus.comparison().End(now);
  program_->TakeResidual();
  return Figures(now, ToSeconds(WallClock::now() - start));
}

}  // namespace

nlohmann::ordered_json RunReplay(const ReplayInput& input) { return Replay(input).Run(); }

}  // namespace pipewright::hil
