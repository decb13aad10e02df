// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "hil/cli/camera_thread.h"
#include "hil/cli/run_figures.h"
#include "hil/cli/run_folder.h"
#include "hil/cli/truth_watch.h"
#include "hil/cli/virtual_run.h"
#include "hil/emulator/emulator.h"
#include "hil/report/run_recorder.h"
#include "platform/core/handover.h"
#include "platform/core/latest.h"

namespace pipewright::hil {

/// One control cycle, on its way from the control thread.
struct CycleRecord {
  ControlReport report;
  Duration took{};
  std::uint64_t allocations = 0;
};

/// The map's figures, on their way from the mapping thread.
struct MapNow {
  MapCounts counts;
  double visual_entropy = kNoReading;
  double coverage_entropy = kNoReading;
};

/// The emulated devices and bodies in real time, in steps of 1 ms; a step that is late is made up
/// for. On a thread of its own, the emulated camera. Beside the devices, what a cycle leaves and
/// whatever needs the truth: trace.csv, figures, the page's samples.
///
///   EmulatorThread emulation(scenario, options, ports, folder, limits);
///   emulation.Start(epoch, threads.frames());   // when the robot program listens
///   emulation.cycles().Push(record);            // control thread
///   emulation.map().Write(map);                 // mapping thread
///   emulation.truth().Read();                   // one more
///   emulation.Stop();                           // then figures(), emulator(), recorder()
class EmulatorThread {
 public:
  /// @param ports  the devices'; empty: they are elsewhere, and so is the truth
  EmulatorThread(const Scenario& scenario, const InspectionOptions& options,
                 const std::vector<Port*>& ports, RunFolder& folder, const RunLimits& limits);
  ~EmulatorThread() { Stop(); }

  /// Switches the devices on. What is recorded, and the stamps of frames, count from `epoch` on the
  /// clock of Now().
  void Start(Time epoch, Latest<DepthFrame>& frames);
  /// Ends it after all that was handed to it has been written.
  void Stop();

  Handover<CycleRecord, 512>& cycles() { return cycles_; }
  Latest<MapNow>& map() { return map_; }
  Latest<std::optional<TruthNow>>& truth() { return truth_; }
  /// Any thread: loads of the buses, 0 to 1.
  void SetLoads(double base, double arm);

  // After Stop().
  RunFigures& figures() { return figures_; }
  /// Null: the devices are elsewhere.
  const Emulator* emulator() const { return emulator_ ? &*emulator_ : nullptr; }
  const RunRecorder& recorder() const { return recorder_; }
  Duration late_max() const { return late_max_; }

 private:
  void Run();
  void Tick(Time now);
  void Record(Time now);
  void Sample(Time now);
  void Take(const DepthFrame& frame);

  std::optional<Emulator> emulator_;
  std::optional<CameraThread> camera_;
  RunFolder& folder_;
  Time epoch_{};
  Time start_{};       ///< from which the emulator's own time counts
  Duration offset_{};  ///< from the emulator's time to that since the epoch
  Latest<DepthFrame>* frames_ = nullptr;
  Handover<CycleRecord, 512> cycles_;
  Latest<MapNow> map_;
  Latest<std::optional<TruthNow>> truth_;
  std::atomic<double> base_load_ = kNoReading;
  std::atomic<double> arm_load_ = kNoReading;
  std::atomic<bool> quit_ = false;
  RunFigures figures_;
  TruthWatch watch_;
  RunRecorder recorder_;
  Time next_sample_{};
  Duration late_max_{};
  std::thread thread_;
};

}  // namespace pipewright::hil
