// SPDX-License-Identifier: MIT
#include "hil/cli/camera_thread.h"

#include <memory>

#include "platform/linux/clock.h"

namespace pipewright::hil {
namespace {

constexpr Duration kViewPeriod = std::chrono::milliseconds(5);
constexpr Duration kPoll = std::chrono::milliseconds(2);

}  // namespace

void CameraThread::Start() {
  thread_ = std::thread([this] { Run(); });
}

void CameraThread::Stop() {
  quit_ = true;
  if (thread_.joinable()) {
    thread_.join();
  }
}

void CameraThread::Look(Time now, Time stamp) {
  if (now < next_view_) {
    return;
  }
  next_view_ += kViewPeriod;
  StampedView& seen = views_.Back();
  emulator_.Look(now, seen.view);
  seen.stamp = stamp;
  views_.Publish();
}

void CameraThread::Run() {
  const auto frame = std::make_unique<DepthFrame>();
  bool watched = false;
  while (!quit_) {
    const StampedView& seen = views_.Read();
    if (seen.view.X_WL.empty() || !emulator_.FrameDue(seen.view) || !wanted_()) {
      watched = watched && wanted_();
      SleepUntil(Now() + kPoll);
      continue;
    }
    const int skipped = emulator_.Render(seen.view, *frame);
    skipped_ += watched ? static_cast<std::uint64_t>(skipped) : 0;
    watched = true;
    frame->stamp = seen.stamp;
    take_(*frame);
    ++frames_;
  }
}

}  // namespace pipewright::hil
