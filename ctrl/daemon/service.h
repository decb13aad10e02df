// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "ctrl/daemon/config.h"
#include "ctrl/daemon/frame_source.h"
#include "ctrl/daemon/service_machine.h"
#include "ctrl/daemon/service_report.h"
#include "ctrl/daemon/task_watch.h"
#include "ctrl/daemon/wires.h"
#include "platform/core/latest.h"
#include "platform/linux/latch_file.h"
#include "platform/linux/line_server.h"
#include "platform/linux/notify.h"

namespace pipewright {

/// The robot as a service: the supervising thread's work between the robot's threads, systemd and
/// the operators. What is to be done is ServiceMachine's to say.
///
///   RobotService service(config, wires, camera, notify, server, latch, grant);
///   service.Begin(Now());
///   while (service.Step(Now(), StopSignals::Pending())) SleepUntil(...);   // each kPeriod
///
/// The heap is touched at start, when a run starts or ends and at re-arming, always while the robot
/// is disabled; a step during a run takes none.
class RobotService final : public ThreadObserver {
 public:
  static constexpr Duration kPeriod = std::chrono::milliseconds(4);

  /// @param grant  what the system gives for real time, settled before
  /// All must outlive this. `server` is open.
  RobotService(const DaemonConfig& config, Wires& wires, FrameSource& camera,
               const ServiceNotify& notify, LineServer& server, const LatchFile& latch,
               const RealtimeGrant& grant);
  ~RobotService();

  /// Tells systemd that it is ready.
  void Begin(Time now);
  /// One turn. @returns false when the service has ended and the robot is at rest
  bool Step(Time now, bool asked_to_end);

  ServiceState state() const { return machine_.state(); }
  std::string_view reason() const { return machine_.reason(); }
  bool stuck(Time now) const { return machine_.stuck(now); }

  /// The answer to one line of an operator: status, start, stop, estop or rearm.
  std::size_t Answer(std::string_view line, const Peer& peer, std::span<char> out);

 private:
  // control, mapping and planning threads
  void OnControl(const ControlReport& report, Duration took) override;
  void OnMap(const MappingTask& mapping, Duration took) override;
  void OnPlan(Time now, const PlanningTask& planning, bool camera_lost, Duration took) override;

  // this one's
  struct PlanNow {
    MissionOutput output;
    bool camera_lost = false;
  };
  struct ControlNow {
    ControlReport report;
    double battery_V = 0;
  };

  void Prepare();
  void Listen();
  void KeepBusOpen();
  void ReadCamera();
  ServiceInput Look();
  void Do(const ServiceOutput& todo);
  std::string StartRun();
  void NoteState();
  void StrokeWatchdog();
  ServiceReport Report();
  bool running() const { return threads_ != nullptr; }

  const DaemonConfig& config_;
  Wires& wires_;
  FrameSource& camera_;
  const ServiceNotify& notify_;
  LineServer& server_;
  const LatchFile& latch_;
  RealtimeGrant grant_;
  ServiceMachine machine_;
  TaskWatch watch_;
  ServiceState told_ = ServiceState::kGone;  ///< to journal and systemd

  RobotProgramConfig program_config_;
  std::unique_ptr<RobotProgram> program_;  ///< ready for the next run, or of the last one
  std::unique_ptr<RobotThreads> threads_;  ///< of a run
  std::string why_;                        ///< the mission's end in words
  Time now_{};
  Time begin_{};
  Time epoch_{};
  Time run_end_{};
  std::uint64_t runs_ = 0;
  CycleStats cycles_;

  Latest<ControlNow> control_;
  Latest<MapCounts> counts_;
  Latest<PlanNow> plan_;
  std::atomic<Duration::rep> worst_cycle_ns_ = 0;

  TracerDriver listener_;  ///< of the base, between runs: is fed, and never stepped
  Time base_heard_{};
  Time arm_heard_{};
  Time next_open_{};
  std::string bus_error_;
  DepthFrame frame_;
  std::uint64_t frames_ = 0;
  bool camera_told_ = false;  ///< that there is none
  Time next_stroke_{};
};

}  // namespace pipewright
