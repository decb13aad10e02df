// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "hil/cli/run_figures.h"
#include "hil/cli/run_folder.h"
#include "hil/cli/truth_watch.h"
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

/// What only the emulator knows, for a person who waits.
struct TruthNow {
  Truth::Coverage coverage;
  int contacts = 0;
};

/// The emulated devices, bodies and camera in real time, in steps of 1 ms; a step that is late is
/// made up for. Beside them, whatever needs the truth: trace.csv, figures, the page's samples.
///
///   EmulatorThread emulation(scenario, options, ports, folder, limits);
///   emulation.Start(epoch, threads.frames());
///   emulation.cycles().Push(record);            // control thread
///   emulation.map().Write(map);                 // mapping thread
///   emulation.truth().Read();                   // one more
///   emulation.Stop();                           // then figures(), emulator(), recorder()
class EmulatorThread {
 public:
  /// @param ports  the devices'; empty: nothing is emulated, nothing moves, no camera sees
  EmulatorThread(const Scenario& scenario, const InspectionOptions& options,
                 const std::vector<Port*>& ports, RunFolder& folder, const RunLimits& limits);
  ~EmulatorThread() { Stop(); }

  /// Its time is that since `epoch`, on the clock of Now().
  void Start(Time epoch, Latest<DepthFrame>& frames);
  /// Ends it after all that was handed to it has been written.
  void Stop();

  Handover<CycleRecord, 512>& cycles() { return cycles_; }
  Latest<MapNow>& map() { return map_; }
  Latest<TruthNow>& truth() { return truth_; }
  /// Any thread: loads of the buses, 0 to 1.
  void SetLoads(double base, double arm);

  bool with_devices() const { return with_devices_; }

  // After Stop().
  RunFigures& figures() { return figures_; }
  const Emulator& emulator() const { return emulator_; }
  const RunRecorder& recorder() const { return recorder_; }
  Duration late_max() const { return late_max_; }

 private:
  struct NoPort final : Port {
    Status Send(const can::Frame&) override { return Status::kUnavailable; }
    bool Receive(can::Frame&) override { return false; }
  };

  void Run();
  void Tick(Time now);
  void Record(Time now);
  void Sample(Time now);

  const bool with_devices_;
  NoPort nowhere_;
  Emulator emulator_;
  RunFolder& folder_;
  Time epoch_{};
  Latest<DepthFrame>* frames_ = nullptr;
  Handover<CycleRecord, 512> cycles_;
  Latest<MapNow> map_;
  Latest<TruthNow> truth_;
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
