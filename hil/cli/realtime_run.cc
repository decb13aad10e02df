// SPDX-License-Identifier: MIT
#include "hil/cli/realtime_run.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <thread>

#include "ctrl/robot_program/threads.h"
#include "hil/cli/heap_watch.h"
#include "hil/cli/run_port.h"
#include "hil/cli/truth_watch.h"
#include "platform/can/cia402.h"
#include "platform/can/tracer.h"
#include "platform/core/handover.h"
#include "platform/linux/clock.h"
#include "platform/robot/uf7.h"

namespace pipewright::hil {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

constexpr Duration kStopTimeout = 5s;   ///< for the robot to come to rest and be disabled
constexpr Duration kFaultTimeout = 1s;  ///< the same at a device fault: quick stop is being sent
constexpr Duration kReadPeriod = 2ms;   ///< of taps and plans

std::int64_t ClockNanoseconds() { return Now().time_since_epoch().count(); }

RobotProgramConfig Timed(RobotProgramConfig config) {
  config.control.law.stopwatch = ClockNanoseconds;
  return config;
}

struct Tap {
  RunPort port;
  LoadMeter load;
  std::string name;
};

/// One control cycle, on its way from the control thread to the emulator's.
struct CycleRecord {
  ControlReport report;
  Duration took{};
  std::uint64_t allocations = 0;
};

/// One planning step, on its way from the planning thread to the main one.
struct PlanRecord {
  Time now{};
  MissionOutput output;
  Goal goal;
  Duration took{};
};

/// What the emulator's thread knows, for a person who waits.
struct TruthNow {
  Truth::Coverage coverage;
  int contacts = 0;
};

class RealtimeRun final : public ThreadObserver {
 public:
  RealtimeRun(const RealtimePorts& ports, const Scenario& scenario,
              const InspectionOptions& options, RunFolder& folder, const RunHooks& hooks)
      : scenario_(scenario),
        options_(options),
        folder_(folder),
        hooks_(hooks),
        with_devices_(!ports.devices.empty()),
        base_(*ports.base, epoch_),
        arm_(*ports.arm, epoch_),
        shared_(ports.base == ports.arm),
        program_(
            std::make_unique<RobotProgram>(Timed(ProgramConfig(scenario, options)), TracerUf7())),
        emulator_(scenario, HomeJoints(TracerUf7()), options.seed,
                  with_devices_ ? ports.devices : std::vector<Port*>{&nowhere_}) {
    for (const RealtimePorts::Tap& tap : ports.taps) {
      const bool arm_alone = taps_.size() == 1;
      taps_.push_back({RunPort(*tap.port, epoch_),
                       LoadMeter(arm_alone ? can::kArmBitrate : can::kTracerBitrate), tap.name});
    }
  }

  nlohmann::ordered_json Run();

 private:
  struct NoPort final : Port {
    Status Send(const can::Frame&) override { return Status::kUnavailable; }
    bool Receive(can::Frame&) override { return false; }
  };

  // control, mapping and planning threads
  void OnControl(const ControlReport& report, Duration took) override;
  void OnMap(const MappingTask& mapping, Duration took) override;
  void OnPlan(Time now, const PlanningTask& planning, bool camera_lost, Duration took) override;
  // the emulator's
  void Emulate();
  void Tick(Time now);
  void Record(Time now);
  // this one's
  RobotThreadsConfig Config() const;
  void Supervise();
  void ReadTaps();
  void ReadPlans();
  bool Done(Time now);
  void ShowProgress(Time now);
  nlohmann::ordered_json Figures(Time end, Status started);

  Time SinceStart() const { return Time{Now() - epoch_}; }

  const Scenario& scenario_;
  const InspectionOptions& options_;
  RunFolder& folder_;
  const RunHooks& hooks_;
  const bool with_devices_;
  NoPort nowhere_;
  Time epoch_{};
  RunPort base_;
  RunPort arm_;
  const bool shared_;
  std::vector<Tap> taps_;
  std::unique_ptr<RobotProgram> program_;
  Emulator emulator_;
  std::unique_ptr<RobotThreads> threads_;

  Handover<CycleRecord, 512> cycles_;  // control -> emulator
  Handover<PlanRecord, 64> plans_;     // planning -> main
  Latest<MapCounts> emulator_counts_;  // mapping -> emulator
  Latest<MapCounts> main_counts_;      // mapping -> main
  Latest<TruthNow> truth_;             // emulator -> main
  std::atomic<bool> emulate_ = true;

  RunFigures figures_;          // the emulator's thread, then this one
  Duration emulator_late_{};    // likewise
  std::vector<float> step_ms_;  // main's
  int plan_steps_ = 0;
  MissionState state_ = MissionState::kStart;
  Time next_progress_{};
  std::optional<Time> stopping_since_;
};

void RealtimeRun::OnControl(const ControlReport& report, Duration took) {
  // The watch sees all that this thread does from the end of its first cycle on.
  thread_local const HeapWatch heap;
  thread_local std::uint64_t before = heap.allocations();
  const std::uint64_t after = heap.allocations();
  cycles_.Push({.report = report, .took = took, .allocations = after - before});
  before = after;
}

void RealtimeRun::OnMap(const MappingTask& mapping, Duration) {
  emulator_counts_.Write(mapping.map().counts());
  main_counts_.Write(mapping.map().counts());
}

void RealtimeRun::OnPlan(Time now, const PlanningTask& planning, bool, Duration took) {
  plans_.Push({.now = now, .output = planning.output(), .goal = planning.goal(), .took = took});
}

void RealtimeRun::Emulate() {
  Time now{};
  while (emulate_) {
    const Time until = SinceStart();
    emulator_late_ = std::max(emulator_late_, until - now);
    while (now + Emulator::kTick <= until && emulate_) {
      now += Emulator::kTick;
      Tick(now);
    }
    SleepUntil(epoch_ + (now + Emulator::kTick).time_since_epoch());
  }
  Record(now);
}

void RealtimeRun::Tick(Time now) {
  if (with_devices_) {
    emulator_.Step(now);
    if (emulator_.FrameDue(now)) {
      emulator_.Render(threads_->frames().Back());
      threads_->frames().Publish();
    }
  }
  Record(now);
}

void RealtimeRun::Record(Time now) {
  while (const CycleRecord* cycle = cycles_.Front()) {
    figures_.Add(cycle->report);
    figures_.heap_allocations += cycle->allocations;
    figures_.cycle_us.push_back(static_cast<float>(1e6 * ToSeconds(cycle->took)));
    const Clearance& clearance = emulator_.Measure(now);
    if (with_devices_) {
      WatchTruth(cycle->report, emulator_, figures_);
    }
    folder_.Trace(cycle->report, emulator_.plant(), clearance, emulator_counts_.Read());
    truth_.Write({emulator_.truth().coverage(), emulator_.truth().contacts()});
    cycles_.Pop();
  }
}

void RealtimeRun::ReadTaps() {
  can::Frame frame;
  for (Tap& tap : taps_) {
    while (tap.port.Receive(frame)) {
      tap.load.Add(frame);
      folder_.Can(frame, tap.name);
    }
  }
}

void RealtimeRun::ReadPlans() {
  while (const PlanRecord* plan = plans_.Front()) {
    state_ = plan->output.state;
    if (plan->output.planned && plan->output.plan_steps != plan_steps_) {
      plan_steps_ = plan->output.plan_steps;
      step_ms_.push_back(static_cast<float>(1e3 * ToSeconds(plan->took)));
      folder_.Plan(PlanJson(plan->now, plan->output, plan->goal, main_counts_.Read()));
    }
    plans_.Pop();
  }
}

bool RealtimeRun::Done(Time now) {
  const bool ended = state_ == MissionState::kDone || state_ == MissionState::kFault ||
                     (hooks_.interrupted && hooks_.interrupted());
  if (ended && !stopping_since_) {
    program_->RequestStop();
    stopping_since_ = now;
  }
  const ControlPhase phase = threads_->phase();
  const Duration patience = phase == ControlPhase::kFault ? kFaultTimeout : kStopTimeout;
  return phase == ControlPhase::kStopped || (stopping_since_ && now - *stopping_since_ > patience);
}

void RealtimeRun::ShowProgress(Time now) {
  if (now < next_progress_ || !hooks_.progress) {
    return;
  }
  next_progress_ = now + Duration{1s};
  const TruthNow& truth = truth_.Read();
  hooks_.progress({now, state_, main_counts_.Read(), truth.coverage, truth.contacts});
}

void RealtimeRun::Supervise() {
  for (Time now = SinceStart(); !Done(now); now = SinceStart()) {
    ReadTaps();
    ReadPlans();
    ShowProgress(now);
    SleepUntil(Now() + kReadPeriod);
  }
}

RobotThreadsConfig RealtimeRun::Config() const {
  RobotThreadsConfig config;
  config.control_period = FromSeconds(1 / options_.rate_hz);
  config.epoch = epoch_;
  config.realtime = options_.ask_fifo;
  return config;
}

nlohmann::ordered_json RealtimeRun::Figures(Time end, Status started) {
  CanFigures can;
  base_.AddTo(can);
  arm_.AddTo(can);
  for (const Tap& tap : taps_) {
    can.load_peak = std::max(can.load_peak, tap.load.Peak());
  }
  figures_.wall_s = ToSeconds(end);
  figures_.step_ms = step_ms_;
  const std::string detail = started == Status::kOk
                                 ? StopDetail(program_->planning().output(),
                                              program_->control().report(), program_->camera_lost())
                                 : "the system gives no threads";
  nlohmann::ordered_json run =
      RunJson(options_, scenario_.name, *program_, emulator_, figures_, can, end, detail);
  const auto granted = [](int error) {
    return std::string(error == 0 ? "granted" : std::strerror(error));
  };
  const RealtimeGrant& grant = threads_->grant();
  const CycleStats cycles = threads_->cycles();
  run["realtime"] = {
      {"devices", with_devices_ ? "emulated" : "elsewhere"},
      {"fifo", options_.ask_fifo ? granted(grant.scheduler_error) : "not asked for"},
      {"memory_lock", options_.ask_fifo ? granted(grant.memory_error) : "not asked for"},
      {"cycles_missed", cycles.missed},
      {"latency_max_us", 1e6 * ToSeconds(cycles.worst_latency)},
      {"emulator_late_max_ms", 1e3 * ToSeconds(emulator_late_)},
      {"trace_lost", cycles_.dropped()},
      {"plans_lost", plans_.dropped()}};
  return run;
}

nlohmann::ordered_json RealtimeRun::Run() {
  epoch_ = Now();
  threads_ = std::make_unique<RobotThreads>(*program_, Config(), this);
  std::thread emulator([this] { Emulate(); });
  const Status started = shared_ ? threads_->Start(base_, base_) : threads_->Start(base_, arm_);
  if (started == Status::kOk) {
    Supervise();
  }
  const Time end = SinceStart();
  threads_->Stop(Duration::zero());
  emulate_ = false;
  emulator.join();
  ReadTaps();
  ReadPlans();
  program_->TakeResidual();
  folder_.Map(program_->mapping().map());
  return Figures(end, started);
}

}  // namespace

nlohmann::ordered_json RunRealtime(const RealtimePorts& ports, const Scenario& scenario,
                                   const InspectionOptions& options, RunFolder& folder,
                                   const RunHooks& hooks) {
  // On the heap: the mailboxes are too big for a stack.
  return std::make_unique<RealtimeRun>(ports, scenario, options, folder, hooks)->Run();
}

}  // namespace pipewright::hil
