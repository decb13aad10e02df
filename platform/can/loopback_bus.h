// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "platform/can/bus.h"
#include "platform/can/frame.h"
#include "platform/core/status.h"
#include "platform/core/time.h"

namespace pipewright::can {

/// Frames waiting, oldest first, in place.
template <int kCapacity>
class FrameQueue {
 public:
  bool Push(const Frame& frame) {
    if (size_ == kCapacity) {
      return false;
    }
    frames_[(first_ + size_) % kCapacity] = frame;
    ++size_;
    return true;
  }
  void Pop() {
    first_ = (first_ + 1) % kCapacity;
    --size_;
  }
  void Clear() { size_ = 0; }
  const Frame& Front() const { return frames_[first_]; }
  bool empty() const { return size_ == 0; }
  int size() const { return size_; }

 private:
  Frame frames_[kCapacity]{};
  int first_ = 0;
  int size_ = 0;
};

struct PortCounters {
  std::uint64_t tx = 0;          ///< frames of this port that the bus has carried
  std::uint64_t tx_dropped = 0;  ///< refused: queue full, or the port is cut
  std::uint64_t rx = 0;          ///< frames handed to this port
  std::uint64_t rx_dropped = 0;  ///< lost because the port's owner did not read them in time
};

/// A CAN bus in virtual time: one wire, up to kMaxPorts nodes, fixed memory, deterministic.
///
/// Each port sends in the order of its queue, as SocketCAN does. Whenever the wire is free, the
/// port whose oldest frame has the lowest id sends (on equal ids the lower port); the frame takes
/// its bits' time, stuff bits counted exactly (FrameBits), and reaches every other port at its end,
/// stamped with that time. A frame that nobody acknowledges keeps the wire busy and is sent again.
///
///   LoopbackBus bus(500'000);
///   LoopbackBus::Port& host = *bus.Attach();
///   LoopbackBus::Port& base = *bus.Attach();
///   LoopbackBus::Port& tap = *bus.AttachListener();  // for can.log
///   host.Send(frame);
///   bus.AdvanceTo(now += 1ms);
///   base.Receive(frame);
///
/// A frame is held to be queued at the time that the last AdvanceTo ended at. Cost of AdvanceTo:
/// per frame carried about 130 bit steps and one pass over the ports. Size: 94 kB.
class LoopbackBus {
 public:
  static constexpr int kMaxPorts = 12;
  static constexpr int kTxCapacity = 64;
  static constexpr int kRxCapacity = 256;

  class Port {
   public:
    /// kFull, kUnavailable (cut), or kMalformed: an id or length that no frame can have.
    Status Send(const Frame& frame);
    bool Receive(Frame& frame);

    /// A cut port neither sends nor hears; what it had queued is lost. For faults.
    void SetCut(bool cut);
    const PortCounters& counters() const { return counters_; }

   private:
    friend class LoopbackBus;
    FrameQueue<kTxCapacity> tx_;
    FrameQueue<kRxCapacity> rx_;
    PortCounters counters_;
    int cuts_ = 0;  ///< times that the port has been cut
    bool cut_ = false;
    bool listener_ = false;
  };

  explicit LoopbackBus(int bitrate, Time start = {});
  LoopbackBus(const LoopbackBus&) = delete;
  LoopbackBus& operator=(const LoopbackBus&) = delete;

  /// A new node, or nullptr when kMaxPorts are attached. Valid as long as the bus.
  Port* Attach();
  /// A node that hears everything, and neither sends nor acknowledges.
  Port* AttachListener();

  /// Carries what is queued until `now`; a frame under way then ends in a later call. Times before
  /// the last call's are ignored.
  void AdvanceTo(Time now);

  Time now() const { return now_; }
  std::uint64_t frames() const { return frames_; }
  std::uint64_t unacknowledged() const { return unacknowledged_; }
  /// Share of the last second in which the wire was busy, in steps of 10 ms; 0 to 1.
  double Load() const;
  /// Largest Load() so far.
  double PeakLoad() const;

 private:
  static constexpr int kLoadSlots = 100;
  static constexpr Duration kLoadSlot = std::chrono::milliseconds(10);

  void Begin(int port, Time start);
  void Complete();
  int Winner() const;
  bool Acknowledged(int sender) const;
  void Deliver(int sender);
  void AddBusy(Time from, Time to);
  void CloseLoadSlots(Time until);

  std::array<Port, kMaxPorts> ports_;
  int port_count_ = 0;
  int bitrate_;
  Time now_;
  Time wire_free_;   ///< end of the frame under way, or of the last one
  int sender_ = -1;  ///< port of the frame under way
  int sender_cuts_ = 0;
  Frame under_way_;
  Time frame_start_{};
  std::uint64_t frames_ = 0;
  std::uint64_t unacknowledged_ = 0;
  std::array<Duration, kLoadSlots> busy_{};  ///< ring; slot_ is being filled
  int slot_ = 0;
  Time slot_start_;
  Duration busy_sum_{};     ///< over the ring, the slot being filled left out
  Duration busy_second_{};  ///< the last full second
  Duration busy_peak_{};
};

static_assert(Bus<LoopbackBus::Port>);

}  // namespace pipewright::can
