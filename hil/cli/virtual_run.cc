// SPDX-License-Identifier: MIT
#include "hil/cli/virtual_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <thread>

#include "ctrl/robot_program/stop_detail.h"
#include "hil/cli/program_loop.h"
#include "hil/cli/report_page.h"
#include "hil/cli/truth_watch.h"
#include "platform/can/cia402.h"
#include "platform/can/loopback_bus.h"
#include "platform/can/tracer.h"
#include "platform/robot/uf7.h"

namespace pipewright::hil {
namespace {

using std::chrono_literals::operator""s;
using WallClock = std::chrono::steady_clock;

constexpr Duration kSamplePeriod = std::chrono::milliseconds(100);  ///< of the report's slow plots
constexpr Duration kStopTimeout = 5s;  ///< for the robot to come to rest and be disabled

static_assert(ProgramLoop::kTick == Emulator::kTick);

std::int64_t WallNanoseconds() { return WallClock::now().time_since_epoch().count(); }

RobotProgramConfig Timed(RobotProgramConfig config) {
  config.control.law.stopwatch = WallNanoseconds;
  return config;
}

/// The buses of one run, with a listener on each for can.log: the base's and the arm's, or one for
/// both, on which every device is a node of its own.
class Wires {
 public:
  explicit Wires(bool shared) : base_(can::kTracerBitrate) {
    AddRobot(base_);
    AddDevices(base_, shared ? kDevices : 1);
    if (!shared) {
      arm_.emplace(can::kArmBitrate);
      AddRobot(*arm_);
      AddDevices(*arm_, 1);
      arm_tap_ = arm_->AttachListener();
    }
    base_tap_ = base_.AttachListener();
  }

  std::vector<Port*> DevicePorts() {
    std::vector<Port*> ports;
    for (PortOf<can::LoopbackBus::Port>& port : devices_) {
      ports.push_back(&port);
    }
    return ports;
  }
  Port& robot_base() { return robot_.front(); }
  Port& robot_arm() { return robot_.back(); }

  void AdvanceTo(Time now, RunFolder& folder) {
    base_.AdvanceTo(now);
    can::Frame frame;
    while (base_tap_->Receive(frame)) {
      folder.Can(frame, "can0");
    }
    if (arm_) {
      arm_->AdvanceTo(now);
      while (arm_tap_->Receive(frame)) {
        folder.Can(frame, "can1");
      }
    }
  }

  double BaseLoad() const { return base_.Load(); }
  double ArmLoad() const { return arm_ ? arm_->Load() : base_.Load(); }

  /// As the robot's ports saw it; what any device's lost is counted too.
  CanFigures Figures() const {
    CanFigures figures;
    for (const can::LoopbackBus::Port* robot : robot_ports_) {
      Add(*robot, figures);
    }
    for (const can::LoopbackBus::Port* device : device_ports_) {
      figures.dropped += Dropped(*device);
    }
    figures.load_peak = base_.PeakLoad();
    if (arm_) {
      figures.load_peak = std::max(figures.load_peak, arm_->PeakLoad());
    }
    return figures;
  }

 private:
  void AddRobot(can::LoopbackBus& bus) {
    can::LoopbackBus::Port& port = *bus.Attach();
    robot_ports_.push_back(&port);
    robot_.emplace_back(port);
  }
  void AddDevices(can::LoopbackBus& bus, int count) {
    for (int i = 0; i < count; ++i) {
      can::LoopbackBus::Port& port = *bus.Attach();
      device_ports_.push_back(&port);
      devices_.emplace_back(port);
    }
  }
  static std::uint64_t Dropped(const can::LoopbackBus::Port& port) {
    return port.counters().tx_dropped + port.counters().rx_dropped;
  }
  static void Add(const can::LoopbackBus::Port& port, CanFigures& figures) {
    figures.tx += port.counters().tx;
    figures.rx += port.counters().rx;
    figures.dropped += Dropped(port);
  }

  can::LoopbackBus base_;
  std::optional<can::LoopbackBus> arm_;
  std::vector<const can::LoopbackBus::Port*> robot_ports_;
  std::deque<PortOf<can::LoopbackBus::Port>> robot_;  ///< the base's and the arm's, or one for both
  std::vector<const can::LoopbackBus::Port*> device_ports_;
  std::deque<PortOf<can::LoopbackBus::Port>> devices_;
  can::LoopbackBus::Port* base_tap_ = nullptr;
  can::LoopbackBus::Port* arm_tap_ = nullptr;
};

class VirtualRun final : public ProgramPeer {
 public:
  VirtualRun(const Scenario& scenario, const InspectionOptions& options, RunFolder& folder,
             const RunHooks& hooks)
      : scenario_(scenario),
        options_(options),
        folder_(folder),
        hooks_(hooks),
        wires_(options.bus == "loopback-shared"),
        program_(
            std::make_unique<RobotProgram>(Timed(ProgramConfig(scenario, options)), TracerUf7())),
        emulator_(scenario, HomeJoints(TracerUf7()), options.seed, wires_.DevicePorts()),
        recorder_(LimitsOf(ProgramConfig(scenario, options))),
        loop_(*program_, FromSeconds(1 / options.rate_hz), *this) {}

  nlohmann::ordered_json Run();

 private:
  void AdvanceTo(Time now) override;
  Port& base() override { return wires_.robot_base(); }
  Port& arm() override { return wires_.robot_arm(); }
  bool See(Time now, DepthFrame& frame) override;
  bool StopAsked(Time now) override;
  void OnControl(const ControlReport& report, std::chrono::nanoseconds took,
                 std::uint64_t allocations) override;
  void OnPlan(Time now, const PlanningTask& planning, std::chrono::nanoseconds took) override;

  void Tick();
  bool Done() const;

  const Scenario& scenario_;
  const InspectionOptions& options_;
  RunFolder& folder_;
  const RunHooks& hooks_;
  Wires wires_;
  std::unique_ptr<RobotProgram> program_;
  Emulator emulator_;
  RunRecorder recorder_;
  nlohmann::ordered_json plan_ = nlohmann::ordered_json::array();
  ProgramLoop loop_;
  Time now_{};
  Time next_sample_{};
  Time next_progress_{};
  std::optional<Time> stopping_since_;
  RunFigures figures_;
  TruthWatch watch_;
  WallClock::time_point wall_start_;
};

void VirtualRun::AdvanceTo(Time now) {
  wires_.AdvanceTo(now, folder_);
  emulator_.Step(now);
}

bool VirtualRun::See(Time now, DepthFrame& frame) {
  const bool due = emulator_.FrameDue(now);
  if (due) {
    emulator_.Render(frame);
    folder_.Depth(frame, now);
  }
  return due;
}

bool VirtualRun::StopAsked(Time now) {
  const bool asked = hooks_.interrupted && hooks_.interrupted();
  if (asked) {
    figures_.interrupted = figures_.interrupted.value_or(now);
    stopping_since_ = stopping_since_.value_or(now);
  }
  return asked;
}

void VirtualRun::OnControl(const ControlReport& report, std::chrono::nanoseconds took,
                           std::uint64_t allocations) {
  const double cycle_us = 1e6 * ToSeconds(took);
  figures_.heap_allocations += allocations;
  figures_.cycle_us.push_back(static_cast<float>(cycle_us));
  figures_.Add(report);
  const Clearance& clearance = emulator_.Measure(report.now);
  watch_.Add(report, emulator_, figures_);
  recorder_.Cycle(ToSeconds(report.now), CycleSampleOf(report, &clearance, cycle_us));
  folder_.Trace(report, &emulator_.plant(), &clearance, program_->mapping().map().counts());
}

void VirtualRun::OnPlan(Time now, const PlanningTask& planning, std::chrono::nanoseconds took) {
  figures_.step_ms.push_back(static_cast<float>(1e3 * ToSeconds(took)));
  plan_.push_back(
      PlanJson(now, planning.output(), planning.goal(), program_->mapping().map().counts()));
  folder_.Plan(plan_.back());
}

void VirtualRun::Tick() {
  loop_.Tick(now_);
  if (now_ >= next_sample_) {
    next_sample_ += kSamplePeriod;
    recorder_.Map(ToSeconds(now_), MapSampleOf(program_->mapping().map(), emulator_,
                                               wires_.BaseLoad(), wires_.ArmLoad()));
  }
  if (now_ >= next_progress_) {
    next_progress_ = now_ + Duration{1s};
    if (hooks_.progress) {
      const Truth& truth = emulator_.truth();
      hooks_.progress({now_, program_->planning().output().state,
                       program_->mapping().map().counts(),
                       TruthNow{truth.coverage().ratio, truth.contacts()}});
    }
  }
}

bool VirtualRun::Done() const {
  const MissionState state = program_->planning().output().state;
  const ControlPhase phase = program_->control().report().phase;
  if (phase == ControlPhase::kStopped) {
    return true;
  }
  const bool ended = state == MissionState::kDone || state == MissionState::kFault;
  return (ended || stopping_since_) && stopping_since_ && now_ - *stopping_since_ > kStopTimeout;
}

nlohmann::ordered_json VirtualRun::Run() {
  assert(program_->status() == Status::kOk);  // options and scenario were checked
  wall_start_ = WallClock::now();
  while (!Done()) {
    Tick();
    const MissionState state = program_->planning().output().state;
    if ((state == MissionState::kDone || state == MissionState::kFault) && !stopping_since_) {
      stopping_since_ = now_;
    }
    now_ += ProgramLoop::kTick;
    if (options_.realtime) {
      std::this_thread::sleep_until(wall_start_ + now_.time_since_epoch());
    }
  }
  figures_.wall_s = ToSeconds(WallClock::now() - wall_start_);
  program_->TakeResidual();
  folder_.Map(program_->mapping().map());
  const std::string detail = StopDetail(program_->planning().output(), program_->control().report(),
                                        program_->camera_lost());
  nlohmann::ordered_json run =
      RunJson(options_, scenario_, *program_, &emulator_, figures_, wires_.Figures(), now_, detail);
  folder_.Text("report.html", ReportPage(run, plan_, recorder_, scenario_, &emulator_.truth()));
  return run;
}

}  // namespace

nlohmann::ordered_json RunVirtual(const Scenario& scenario, const InspectionOptions& options,
                                  RunFolder& folder, const RunHooks& hooks) {
  return VirtualRun(scenario, options, folder, hooks).Run();
}

}  // namespace pipewright::hil
