// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "hil/devices/port.h"
#include "platform/core/rng.h"
#include "platform/core/time.h"

namespace pipewright::hil {

/// Which frames a fault is about.
using FrameMatch = std::function<bool(const can::Frame&)>;

/// What became of frames.
struct FaultyPortCounters {
  std::uint64_t lost = 0;
  std::uint64_t duplicated = 0;
  std::uint64_t delayed = 0;
  std::uint64_t swapped = 0;     ///< pairs of one id
  std::uint64_t inserted = 0;    ///< replayed ones too
  std::uint64_t rx_dropped = 0;  ///< the owner did not read in time
  std::uint64_t tx_refused = 0;
};

/// One node's access to a bus, through a wire or a controller at fault.
///
///   FaultyPort port(inner);
///   port.Lose(3, [](const can::Frame& f) { return f.id == 0x221; });   // the next three
///   port.SetSend(Status::kFull);                                       // ENOBUFS, from now on
///   ... port.AdvanceTo(now);                                           // each tick
///
/// A frame keeps the stamp that it came with however late it is handed on, as one does that the
/// kernel stamps; what is inserted is stamped when it is. The queue towards the owner is bounded,
/// and drops the newest, as the kernel's does. A port without a fault is the inner port.
class FaultyPort final : public Port {
 public:
  static constexpr int kRxCapacity = 256;

  /// `inner` must outlive this.
  explicit FaultyPort(Port& inner) : inner_(inner) {}

  Status Send(const can::Frame& frame) override;
  bool Receive(can::Frame& frame) override;

  /// Takes what has come until `now`, each frame to the fault that was set first and matches it.
  void AdvanceTo(Time now);

  // Faults of the next `frames` that match.
  void Lose(int frames, FrameMatch match);
  void Duplicate(int frames, FrameMatch match);
  void Delay(int frames, Duration by, FrameMatch match);
  /// The next that matches comes after the next but one of its id.
  void Swap(FrameMatch match);

  /// Heard at the next AdvanceTo.
  void Insert(const can::Frame& frame);
  /// One of the last kRemembered frames again. False: none has come yet.
  bool Replay(Rng& rng);

  /// What Send() answers from now on; kOk: what the inner port does.
  void SetSend(Status status) { send_ = status; }
  /// Nothing is heard, and kUnavailable is what Send() answers.
  void SetDown(bool down) { down_ = down; }
  /// Added to the stamp of what comes from now on: a clock that was set.
  void SetStampOffset(Duration offset) { stamp_offset_ = offset; }

  const FaultyPortCounters& counters() const { return counters_; }

 private:
  enum class Kind : std::uint8_t { kLose, kDuplicate, kDelay, kSwap };
  struct Rule {
    Kind kind;
    int left;
    FrameMatch match;
    Duration by{};
  };
  struct Late {
    Time due;
    can::Frame frame;
  };
  static constexpr std::size_t kRemembered = 1000;

  void Take(const can::Frame& frame, Time now);
  void Push(const can::Frame& frame);

  Port& inner_;
  std::vector<Rule> rules_;
  std::vector<Late> late_;
  std::vector<can::Frame> inserted_;
  std::optional<can::Frame> swapped_;
  std::deque<can::Frame> queue_;
  std::deque<can::Frame> memory_;
  Status send_ = Status::kOk;
  bool down_ = false;
  Duration stamp_offset_{};
  FaultyPortCounters counters_;
};

}  // namespace pipewright::hil
