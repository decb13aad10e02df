// SPDX-License-Identifier: MIT
#include "hil/cli/emulator_thread.h"

#include <algorithm>

#include "hil/cli/report_page.h"
#include "platform/linux/clock.h"
#include "platform/robot/uf7.h"

namespace pipewright::hil {
namespace {

constexpr Duration kSamplePeriod = std::chrono::milliseconds(100);  ///< of the page's slow plots

}  // namespace

EmulatorThread::EmulatorThread(const Scenario& scenario, const InspectionOptions& options,
                               const std::vector<Port*>& ports, RunFolder& folder,
                               const RunLimits& limits)
    : folder_(folder), recorder_(limits) {
  if (!ports.empty()) {
    emulator_.emplace(scenario, HomeJoints(TracerUf7()), options.seed, ports);
    camera_.emplace(
        *emulator_, [] { return true; }, [this](const DepthFrame& frame) { Take(frame); });
  }
}

void EmulatorThread::Start(Time epoch, Latest<DepthFrame>& frames) {
  epoch_ = epoch;
  start_ = Now();
  offset_ = start_ - epoch_;
  frames_ = &frames;
  thread_ = std::thread([this] { Run(); });
  if (camera_) {
    camera_->Start();
  }
}

void EmulatorThread::Stop() {
  quit_ = true;
  if (camera_) {
    camera_->Stop();
  }
  if (thread_.joinable()) {
    thread_.join();
  }
}

void EmulatorThread::SetLoads(double base, double arm) {
  base_load_.store(base, std::memory_order_relaxed);
  arm_load_.store(arm, std::memory_order_relaxed);
}

void EmulatorThread::Run() {
  Time now{};
  while (!quit_) {
    const Time until{Now() - start_};
    late_max_ = std::max(late_max_, until - now);
    while (now + Emulator::kTick <= until && !quit_) {
      now += Emulator::kTick;
      Tick(now);
    }
    SleepUntil(start_ + (now + Emulator::kTick).time_since_epoch());
  }
  Record(now);
}

void EmulatorThread::Tick(Time now) {
  if (emulator_) {
    emulator_->Step(now);
    camera_->Look(now, now + offset_);
  }
  Record(now);
  if (now >= next_sample_) {
    next_sample_ += kSamplePeriod;
    Sample(now);
  }
}

void EmulatorThread::Take(const DepthFrame& frame) {
  folder_.Depth(frame, Time{Now() - epoch_});
  frames_->Write(frame);
}

void EmulatorThread::Record(Time now) {
  while (const CycleRecord* cycle = cycles_.Front()) {
    const ControlReport& report = cycle->report;
    const double cycle_us = 1e6 * ToSeconds(cycle->took);
    figures_.Add(report);
    figures_.heap_allocations += cycle->allocations;
    figures_.cycle_us.push_back(static_cast<float>(cycle_us));
    const Clearance* clearance = emulator_ ? &emulator_->Measure(now) : nullptr;
    if (emulator_) {
      watch_.Add(report, *emulator_, figures_);
    }
    recorder_.Cycle(ToSeconds(report.now), CycleSampleOf(report, clearance, cycle_us));
    folder_.Trace(report, emulator_ ? &emulator_->plant() : nullptr, clearance, map_.Read().counts);
    cycles_.Pop();
  }
}

void EmulatorThread::Sample(Time now) {
  const MapNow& map = map_.Read();
  MapSample sample;
  sample.free = map.counts.free;
  sample.occupied = map.counts.occupied;
  sample.unknown = map.counts.unknown;
  sample.covered = map.counts.covered;
  sample.visual_entropy = map.visual_entropy;
  sample.coverage_entropy = map.coverage_entropy;
  sample.base_bus_load = base_load_.load(std::memory_order_relaxed);
  sample.arm_bus_load = arm_load_.load(std::memory_order_relaxed);
  if (emulator_) {
    const double coverage_ratio = emulator_->truth().coverage().ratio;
    sample.coverage_ratio = coverage_ratio;
    sample.p_WP = emulator_->plant().p_WP();
    truth_.Write(TruthNow{coverage_ratio, emulator_->truth().contacts()});
  }
  recorder_.Map(ToSeconds(now + offset_), sample);
}

}  // namespace pipewright::hil
