// SPDX-License-Identifier: MIT
#include "ctrl/daemon/service.h"

#include <algorithm>
#include <cstdio>

#include "ctrl/robot_program/stop_detail.h"
#include "platform/can/cia402.h"
#include "platform/linux/clock.h"
#include "platform/linux/journal.h"
#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

constexpr Duration kRetry = 1s;       ///< between two tries to open the buses
constexpr Duration kHeard = 1s;       ///< a device that was heard within this is there
constexpr int kStrokes = 4;           ///< to one watchdog period
constexpr int kFramesPerStep = 1024;  ///< of the buses, listened to between runs
constexpr std::string_view kUnderWay = "a run was under way when the service last ended";

std::int64_t ClockNanoseconds() { return Now().time_since_epoch().count(); }

RobotProgramConfig Timed(RobotProgramConfig config) {
  config.control.law.stopwatch = ClockNanoseconds;
  return config;
}

TaskBounds BoundsOf(const DaemonConfig& config) {
  return {config.task_bound, config.task_bound, config.planning_bound};
}

bool IsArmHeartbeat(const can::Frame& frame) {
  const int node = static_cast<int>(frame.id) - static_cast<int>(can::kHeartbeat.head.id);
  return !frame.error && !frame.extended && !frame.remote && 1 <= node && node <= can::kArmNodes;
}

/// What may stand between quotes in an answer.
std::string Plain(std::string_view text) {
  std::string plain(text.substr(0, 200));
  std::replace_if(
      plain.begin(), plain.end(),
      [](char c) { return c < ' ' || c > '~' || c == '"' || c == '\\'; }, '?');
  return plain;
}

template <typename... Words>
void SayWords(Severity severity, const char* format, Words... words) {
  char line[400];
  const int size = std::snprintf(line, sizeof line, format, words...);
  Say(severity, {line, std::min(sizeof line - 1, static_cast<std::size_t>(std::max(size, 0)))});
}

}  // namespace

RobotService::RobotService(const DaemonConfig& config, Wires& wires, FrameSource& camera,
                           const ServiceNotify& notify, LineServer& server, const LatchFile& latch,
                           const RealtimeGrant& grant)
    : config_(config),
      wires_(wires),
      camera_(camera),
      notify_(notify),
      server_(server),
      latch_(latch),
      grant_(grant),
      machine_(config.autostart, latch.Read()),
      watch_(BoundsOf(config)),
      program_config_(Timed(ProgramConfigOf(config))),
      listener_(program_config_.control.base) {
  Prepare();
}

RobotService::~RobotService() = default;

/// Takes the memory of a run; nothing is sent before it starts.
void RobotService::Prepare() {
  program_.reset();  // two at a time might not fit
  program_ = std::make_unique<RobotProgram>(program_config_, TracerUf7());
}

void RobotService::Begin(Time now) {
  begin_ = now_ = now;
  KeepBusOpen();
  const bool heard = notify_.Send("READY=1") == Status::kOk;
  Say(Severity::kInfo, heard ? "ready; systemd is told so" : "ready");
}

void RobotService::OnControl(const ControlReport& report, Duration took) {
  ControlNow& now = control_.Back();
  now.report = report;
  now.battery_V = program_->control().base().battery_V();
  control_.Publish();
  if (took.count() > worst_cycle_ns_.load(std::memory_order_relaxed)) {
    worst_cycle_ns_.store(took.count(), std::memory_order_relaxed);
  }
}

void RobotService::OnMap(const MappingTask& mapping, Duration) {
  counts_.Write(mapping.map().counts());
}

void RobotService::OnPlan(Time, const PlanningTask& planning, bool camera_lost, Duration) {
  plan_.Write({planning.output(), camera_lost});
}

/// Between runs: who is on the buses.
void RobotService::Listen() {
  can::Frame frame;
  for (int i = 0; i < kFramesPerStep && wires_.Listen(frame); ++i) {
    listener_.OnFrame(frame);
    if (IsArmHeartbeat(frame)) {
      arm_heard_ = now_;
    }
  }
  base_heard_ = listener_.state_stamp();
}

void RobotService::KeepBusOpen() {
  if (wires_.is_open()) {
    return;
  }
  if (now_ < next_open_) {
    return;
  }
  next_open_ = now_ + kRetry;
  if (wires_.Open() == Status::kOk) {
    bus_error_.clear();
    SayWords(Severity::kInfo, "buses open: base on %s, arm on %s", config_.base_can.c_str(),
             config_.arm_can.c_str());
  } else if (const std::string why = Plain(wires_.error_text()); why != bus_error_) {
    bus_error_ = why;
    SayWords(Severity::kWarning, "no bus to the robot: %s; trying again each second", why.c_str());
  }
}

void RobotService::ReadCamera() {
  const Status status = camera_.Poll(now_, frame_);
  if (status == Status::kOk) {
    ++frames_;
    if (camera_told_) {
      camera_told_ = false;
      Say(Severity::kInfo, "the camera sends frames");
    }
    if (running() && frame_.stamp > epoch_) {
      DepthFrame& back = threads_->frames().Back();
      back = frame_;
      back.stamp = Time{frame_.stamp - epoch_};
      threads_->frames().Publish();
    }
  } else if (status == Status::kUnavailable && !camera_told_) {
    camera_told_ = true;
    SayWords(Severity::kWarning, "no camera: %s; trying again each second",
             Plain(camera_.error_text()).c_str());
  }
}

/// What the machine is to know.
ServiceInput RobotService::Look() {
  ServiceInput input;
  input.bus_ok = running() || wires_.is_open();
  if (!running()) {
    return input;
  }
  watch_.See(threads_->turns(), now_);
  const PlanNow& plan = plan_.Read();
  input.phase = threads_->phase();
  input.silent_task = machine_.state() == ServiceState::kRunning ? watch_.Silent(now_) : nullptr;
  input.threads_returned = threads_->returned();
  input.mission_ended =
      plan.output.state == MissionState::kDone || plan.output.state == MissionState::kFault;
  if (input.mission_ended && why_.empty()) {
    const std::string detail = StopDetail(plan.output, control_.Read().report, plan.camera_lost);
    why_ = Plain(std::string(Name(plan.output.stop)) + (detail.empty() ? "" : ": " + detail));
  }
  input.why = why_;
  return input;
}

/// @returns why it could not be started; empty if it was
std::string RobotService::StartRun() {
  if (latch_.Set(kUnderWay) != Status::kOk) {
    return Plain("cannot write " + latch_.path() +
                 ", and so could not tell after a crash that the robot moved");
  }
  RobotThreadsConfig config;
  config.control_period = FromSeconds(1 / config_.rate_hz);
  config.epoch = epoch_ = now_;
  config.realtime = config_.ask_realtime;
  config.request = config_.realtime;
  if (runs_ > 0) {
    Prepare();
  }
  ++runs_;
  why_.clear();
  worst_cycle_ns_ = 0;
  plan_.Write({});
  counts_.Write({});
  control_.Write({});
  static_cast<void>(control_.Read());
  threads_ = std::make_unique<RobotThreads>(*program_, config, this);
  now_ = Now();  // memory has been taken meanwhile
  watch_.Start(now_);
  const Status status = wires_.Start(*threads_, epoch_);
  grant_ = config_.ask_realtime ? threads_->grant() : grant_;
  const bool granted = grant_.complete() || !config_.require_realtime;
  if (status == Status::kOk && granted) {
    return "";
  }
  threads_.reset();
  return granted ? std::string("the system gives no threads: ") + Name(status)
                 : "the system no longer grants real time";
}

void RobotService::Do(const ServiceOutput& todo) {
  if (todo.start) {
    machine_.Started(StartRun());
  }
  if (todo.request_stop) {
    program_->RequestStop();
  }
  if (todo.quit) {
    threads_->Quit();
  }
  if (todo.join) {
    threads_->Stop(Duration::zero());
    cycles_ = threads_->cycles();
    threads_.reset();
    run_end_ = now_;
    listener_ = TracerDriver(program_config_.control.base);
  }
}

/// Tells journal, systemd and the latch what the service is now.
void RobotService::NoteState() {
  const ServiceState state = machine_.state();
  if (state == told_) {
    return;
  }
  told_ = state;
  const std::string why(machine_.reason());
  SayWords(machine_.latched() ? Severity::kNotice : Severity::kInfo, "%s%s%s%s", Name(state),
           why.empty() ? "" : ": ", why.c_str(),
           machine_.latched() ? " (latched until `pipewright rearm`)" : "");
  char status[300];
  std::snprintf(status, sizeof status, "%sSTATUS=%s%s%s",
                state == ServiceState::kGone ? "STOPPING=1\n" : "", Name(state),
                why.empty() ? "" : ": ", why.c_str());
  static_cast<void>(notify_.Send(status));
  Status kept = Status::kOk;
  if (state == ServiceState::kEmergencyStop) {
    kept = latch_.Set(why);
  } else if (state == ServiceState::kEnded || state == ServiceState::kIdle ||
             state == ServiceState::kNoBus) {
    kept = latch_.Clear();
  }
  if (kept != Status::kOk) {
    SayWords(Severity::kError, "cannot write %s: the latch will not outlive the service",
             latch_.path().c_str());
  }
}

void RobotService::StrokeWatchdog() {
  if (notify_.watchdog() == Duration::zero() || now_ < next_stroke_) {
    return;
  }
  if (running() && !watch_.MayStroke(now_)) {
    return;  // looked at again with the next turn
  }
  watch_.Stroked();
  next_stroke_ = now_ + notify_.watchdog() / kStrokes;
  static_cast<void>(notify_.Send("WATCHDOG=1"));
}

bool RobotService::Step(Time now, bool asked_to_end) {
  now_ = now;
  if (!running()) {
    Listen();
    KeepBusOpen();
  }
  ReadCamera();
  server_.Poll(now, [this](std::string_view line, const Peer& peer, std::span<char> out) {
    return Answer(line, peer, out);
  });
  ServiceInput input = Look();
  input.asked_to_end = asked_to_end;
  Do(machine_.Step(input, now_));
  NoteState();
  StrokeWatchdog();
  return machine_.state() != ServiceState::kGone;
}

ServiceReport RobotService::Report() {
  const ControlNow& control = control_.Read();
  const PlanNow& plan = plan_.Read();
  const ControlReport& last = control.report;
  const Duration since_control = Time{now_ - epoch_} - last.state.stamp;
  ServiceReport r;
  r.state = machine_.state();
  r.reason = machine_.reason();
  r.latched = machine_.latched();
  r.uptime_s = ToSeconds(Time{now_ - begin_});
  r.base_can = config_.base_can;
  r.arm_can = config_.arm_can;
  r.bus_error = wires_.is_open() ? std::string_view() : std::string_view(bus_error_);
  r.base_heard = running() ? last.state.valid && since_control < kHeard
                           : base_heard_ > Time{} && now_ - base_heard_ < kHeard;
  r.arm_heard = running() ? r.base_heard : arm_heard_ > Time{} && now_ - arm_heard_ < kHeard;
  r.battery_V = running() ? control.battery_V : listener_.battery_V();
  r.base_emergency_stop = running() ? last.state.emergency_stop : listener_.emergency_stop();
  r.camera_error = camera_told_ ? camera_.error_text() : std::string_view();
  r.camera_frames = frames_;
  r.fifo = grant_.scheduler_error == 0;
  r.memory_locked = grant_.memory_error == 0;
  r.runs = runs_;
  r.run_s = runs_ == 0 ? 0 : ToSeconds(Time{(running() ? now_ : run_end_) - epoch_});
  r.phase = last.phase;
  r.mission = plan.output.state;
  r.stop = plan.output.stop;
  r.counts = counts_.Read();
  r.plan_steps = plan.output.plan_steps;
  r.goals_reached = plan.output.reached;
  r.pose = last.state.q.head<3>();
  r.cycles = running() ? threads_->cycles() : cycles_;
  r.worst_cycle = Duration(worst_cycle_ns_.load(std::memory_order_relaxed));
  return r;
}

std::size_t RobotService::Answer(std::string_view line, const Peer& peer, std::span<char> out) {
  if (line == "status") {
    return ReportJson(Report(), out);
  }
  std::optional<ServiceCommand> command;
  if (line == "start") {
    command = ServiceCommand::kStart;
  } else if (line == "stop") {
    command = ServiceCommand::kStop;
  } else if (line == "estop") {
    command = ServiceCommand::kEmergencyStop;
  } else if (line == "rearm") {
    command = ServiceCommand::kRearm;
  }
  if (!command) {
    return AnswerJson("not a request: status, start, stop, estop, rearm", out);
  }
  const char* refused = machine_.Command(*command);
  SayWords(Severity::kNotice, "%.*s, asked for by user %u, process %d: %s",
           static_cast<int>(line.size()), line.data(), peer.uid, peer.pid,
           refused == nullptr ? "taken" : refused);
  return AnswerJson(refused == nullptr ? "" : refused, out);
}

}  // namespace pipewright
