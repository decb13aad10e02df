// SPDX-License-Identifier: MIT
#include "hil/cli/realtime_run.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cstring>
#include <memory>
#include <thread>

#include "ctrl/robot_program/stop_detail.h"
#include "ctrl/robot_program/threads.h"
#include "hil/cli/emulator_thread.h"
#include "hil/cli/heap_watch.h"
#include "hil/cli/report_page.h"
#include "hil/cli/run_port.h"
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
constexpr Duration kCameraPoll = 2ms;

std::int64_t ClockNanoseconds() { return Now().time_since_epoch().count(); }

RobotProgramConfig Timed(RobotProgramConfig config) {
  config.control.law.stopwatch = ClockNanoseconds;
  return config;
}

/// Frames that came and found no room.
std::uint64_t FramesLost(const std::vector<SocketCan*>& sockets) {
  std::uint64_t lost = 0;
  for (const SocketCan* socket : sockets) {
    lost += socket->rx_dropped();
  }
  return lost;
}

struct Tap {
  RunPort port;
  LoadMeter load;
  std::string name;
};

/// One planning step, on its way from the planning thread to the main one.
struct PlanRecord {
  Time now{};
  MissionOutput output;
  Goal goal;
  Duration took{};
};

class RealtimeRun final : public ThreadObserver {
 public:
  RealtimeRun(const RealtimePorts& ports, const Scenario& scenario,
              const InspectionOptions& options, RunFolder& folder, const RunHooks& hooks)
      : scenario_(scenario),
        options_(options),
        folder_(folder),
        hooks_(hooks),
        base_(*ports.base, epoch_),
        arm_(*ports.arm, epoch_),
        shared_(ports.base == ports.arm),
        robot_sockets_(ports.robot_sockets),
        tap_sockets_(ports.tap_sockets),
        camera_(ports.camera),
        program_(
            std::make_unique<RobotProgram>(Timed(ProgramConfig(scenario, options)), TracerUf7())),
        emulation_(scenario, options, ports.devices, folder,
                   LimitsOf(ProgramConfig(scenario, options))) {
    for (const RealtimePorts::Tap& tap : ports.taps) {
      const bool arm_alone = taps_.size() == 1;
      taps_.push_back({RunPort(*tap.port, epoch_),
                       LoadMeter(arm_alone ? can::kArmBitrate : can::kTracerBitrate), tap.name});
    }
  }

  nlohmann::ordered_json Run();

 private:
  // control, mapping and planning threads
  void OnControl(const ControlReport& report, Duration took) override;
  void OnMap(const MappingTask& mapping, Duration took) override;
  void OnPlan(Time now, const PlanningTask& planning, bool camera_lost, Duration took) override;
  // the camera's, where it is elsewhere
  void CameraLoop();
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
  Time epoch_{};
  RunPort base_;
  RunPort arm_;
  const bool shared_;
  const std::vector<SocketCan*> robot_sockets_;
  const std::vector<SocketCan*> tap_sockets_;
  DepthSocket* camera_;
  std::vector<Tap> taps_;
  std::unique_ptr<RobotProgram> program_;
  EmulatorThread emulation_;
  std::unique_ptr<RobotThreads> threads_;

  Handover<PlanRecord, 64> plans_;  // planning -> this thread
  Latest<MapCounts> counts_;        // mapping -> this thread

  nlohmann::ordered_json plan_ = nlohmann::ordered_json::array();
  std::vector<float> step_ms_;
  int plan_steps_ = 0;
  MissionState state_ = MissionState::kStart;
  Time next_progress_{};
  std::optional<Time> stopping_since_;
  std::optional<Time> interrupted_;
  std::atomic<bool> camera_quit_ = false;
  std::atomic<std::uint64_t> camera_frames_ = 0;
};

void RealtimeRun::OnControl(const ControlReport& report, Duration took) {
  // The watch sees all that this thread does from the end of its first cycle on.
  thread_local const HeapWatch heap;
  thread_local std::uint64_t before = heap.allocations();
  const std::uint64_t after = heap.allocations();
  emulation_.cycles().Push({.report = report, .took = took, .allocations = after - before});
  before = after;
}

void RealtimeRun::OnMap(const MappingTask& mapping, Duration) {
  const VoxelGrid& map = mapping.map();
  emulation_.map().Write({map.counts(), map.visual_entropy(), map.coverage_entropy()});
  counts_.Write(map.counts());
}

void RealtimeRun::OnPlan(Time now, const PlanningTask& planning, bool, Duration took) {
  plans_.Push({.now = now, .output = planning.output(), .goal = planning.goal(), .took = took});
}

void RealtimeRun::CameraLoop() {
  Latest<DepthFrame>& frames = threads_->frames();
  while (!camera_quit_) {
    if (camera_->Poll(Now(), frames.Back()) != Status::kOk) {
      SleepUntil(Now() + kCameraPoll);
      continue;
    }
    frames.Back().stamp = Time{frames.Back().stamp - epoch_};
    frames.Publish();
    ++camera_frames_;
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
  if (!taps_.empty()) {
    emulation_.SetLoads(taps_.front().load.Last(), taps_.back().load.Last());
  }
}

void RealtimeRun::ReadPlans() {
  while (const PlanRecord* plan = plans_.Front()) {
    state_ = plan->output.state;
    if (plan->output.planned && plan->output.plan_steps != plan_steps_) {
      plan_steps_ = plan->output.plan_steps;
      step_ms_.push_back(static_cast<float>(1e3 * ToSeconds(plan->took)));
      plan_.push_back(PlanJson(plan->now, plan->output, plan->goal, counts_.Read()));
      folder_.Plan(plan_.back());
    }
    plans_.Pop();
  }
}

bool RealtimeRun::Done(Time now) {
  const bool interrupted = hooks_.interrupted && hooks_.interrupted();
  if (interrupted) {
    interrupted_ = interrupted_.value_or(now);
  }
  const bool ended = state_ == MissionState::kDone || state_ == MissionState::kFault || interrupted;
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
  hooks_.progress({now, state_, counts_.Read(), emulation_.truth().Read()});
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
  RunFigures& figures = emulation_.figures();
  figures.wall_s = ToSeconds(end);
  figures.step_ms = step_ms_;
  figures.interrupted = interrupted_;
  const std::string detail = started == Status::kOk
                                 ? StopDetail(program_->planning().output(),
                                              program_->control().report(), program_->camera_lost())
                                 : "the system gives no threads";
  nlohmann::ordered_json run =
      RunJson(options_, scenario_, *program_, emulation_.emulator(), figures, can, end, detail);
  const auto granted = [](int error) {
    return std::string(error == 0 ? "granted" : std::strerror(error));
  };
  const RealtimeGrant& grant = threads_->grant();
  const CycleStats cycles = threads_->cycles();
  run["realtime"] = {
      {"devices", emulation_.emulator() != nullptr ? "emulated" : "elsewhere"},
      {"camera_frames", camera_ != nullptr ? nlohmann::ordered_json(camera_frames_.load())
                                           : nlohmann::ordered_json(nullptr)},
      {"fifo", options_.ask_fifo ? granted(grant.scheduler_error) : "not asked for"},
      {"memory_lock", options_.ask_fifo ? granted(grant.memory_error) : "not asked for"},
      {"cycles_missed", cycles.missed},
      {"latency_max_us", 1e6 * ToSeconds(cycles.worst_latency)},
      {"emulator_late_max_ms", 1e3 * ToSeconds(emulation_.late_max())},
      {"trace_lost", emulation_.cycles().dropped()},
      {"plans_lost", plans_.dropped()},
      {"rx_lost", FramesLost(robot_sockets_)},
      {"log_lost", FramesLost(tap_sockets_)}};
  return run;
}

nlohmann::ordered_json RealtimeRun::Run() {
  assert(program_->status() == Status::kOk);  // options and scenario were checked
  for (const std::vector<SocketCan*>* sockets : {&robot_sockets_, &tap_sockets_}) {
    for (SocketCan* socket : *sockets) {
      socket->Discard();  // devices elsewhere have been talking since the interface was opened
    }
  }
  epoch_ = Now();
  threads_ = std::make_unique<RobotThreads>(*program_, Config(), this);
  const Status started = shared_ ? threads_->Start(base_, base_) : threads_->Start(base_, arm_);
  std::thread camera;
  if (started == Status::kOk) {
    // Not before: locking memory takes its time, and nobody would take the devices' first words.
    emulation_.Start(epoch_, threads_->frames());
    if (camera_ != nullptr) {
      camera = std::thread([this] { CameraLoop(); });
    }
    Supervise();
  }
  const Time end = SinceStart();
  camera_quit_ = true;
  if (camera.joinable()) {
    camera.join();
  }
  threads_->Stop(Duration::zero());
  emulation_.Stop();
  ReadTaps();
  ReadPlans();
  program_->TakeResidual();
  folder_.Map(program_->mapping().map());
  nlohmann::ordered_json run = Figures(end, started);
  const Emulator* emulator = emulation_.emulator();
  folder_.Text("report.html", ReportPage(run, plan_, emulation_.recorder(), scenario_,
                                         emulator != nullptr ? &emulator->truth() : nullptr));
  return run;
}

}  // namespace

nlohmann::ordered_json RunRealtime(const RealtimePorts& ports, const Scenario& scenario,
                                   const InspectionOptions& options, RunFolder& folder,
                                   const RunHooks& hooks) {
  // On the heap: the mailboxes are too big for a stack.
  return std::make_unique<RealtimeRun>(ports, scenario, options, folder, hooks)->Run();
}

}  // namespace pipewright::hil
