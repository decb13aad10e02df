// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

#include "hil/emulator/emulator.h"
#include "platform/core/latest.h"

namespace pipewright::hil {

/// The emulated camera on a thread of its own, so that a picture that takes its time delays no
/// device. It sees the robot where it was some 5 ms ago at most, and says when that was.
///
///   CameraThread camera(emulator, wanted, take);
///   camera.Start();
///   emulator.Step(now);
///   camera.Look(now, Now());   // after each step
///   camera.Stop();             // before the emulator goes
class CameraThread {
 public:
  /// @param wanted  whether anyone would look at a frame now
  /// @param take    a frame, stamped as its Look() was; both are called on the camera's thread
  CameraThread(Emulator& emulator, std::function<bool()> wanted,
               std::function<void(const DepthFrame&)> take)
      : emulator_(emulator), wanted_(std::move(wanted)), take_(std::move(take)) {}
  ~CameraThread() { Stop(); }
  CameraThread(const CameraThread&) = delete;
  CameraThread& operator=(const CameraThread&) = delete;

  void Start();
  void Stop();

  /// The stepping thread's.
  /// @param now    the emulator's time
  /// @param stamp  the same on the clock of who takes the frames
  void Look(Time now, Time stamp);

  // After Stop().
  std::uint64_t frames() const { return frames_; }
  /// That were due while somebody wanted them, and never came.
  std::uint64_t skipped() const { return skipped_; }

 private:
  struct StampedView {
    Emulator::View view;
    Time stamp{};
  };

  void Run();

  Emulator& emulator_;
  const std::function<bool()> wanted_;
  const std::function<void(const DepthFrame&)> take_;
  Latest<StampedView> views_;
  Time next_view_{};
  std::atomic<bool> quit_ = false;
  std::uint64_t frames_ = 0;
  std::uint64_t skipped_ = 0;
  std::thread thread_;
};

}  // namespace pipewright::hil
