// SPDX-License-Identifier: MIT
#pragma once

#include <linux/can.h>

#include <cstdint>
#include <string_view>

#include "platform/can/bus.h"
#include "platform/can/frame.h"
#include "platform/core/status.h"
#include "platform/core/time.h"

namespace pipewright {

/// The kernel's frame for ours: flags for 29-bit, remote and error frames go into can_id.
can_frame ToKernel(const can::Frame& frame);
/// Ours for the kernel's; the stamp is left at zero. A length beyond 8 is cut to 8.
can::Frame FromKernel(const can_frame& kernel);

/// A CAN interface of the kernel (SocketCAN, raw, classic frames), never waiting. Error frames of
/// the controller are received as frames too. Both queues are the kernel's and bounded: what does
/// not fit is dropped and counted, tx_dropped() and rx_dropped(). A link that goes down and comes
/// up again needs no new Open(). Not for sharing between threads.
///
///   SocketCan bus;
///   if (bus.Open("can0") != Status::kOk) return Complain(bus.error_text());
///   bus.Send(frame);
///   while (bus.Receive(frame)) ...
class SocketCan {
 public:
  SocketCan() = default;
  ~SocketCan() { Close(); }
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;

  /// kMalformed: no name that an interface can have. kUnavailable: the kernel has no CAN, there is
  /// no such interface, it is not a CAN one, it is down, or it is not ours to open; error_text()
  /// says which.
  Status Open(std::string_view interface);
  void Close();
  bool is_open() const { return socket_ >= 0; }

  /// Room for some `frames` received and not yet read, where the system grants it; its default is
  /// some 270. For a listener that may be late.
  void GrowReceiveQueue(int frames);

  /// Forgets what came so far, and what of it was lost: a run does not begin with old news.
  void Discard();

  /// kFull: the transmit queue is full (ENOBUFS, EAGAIN); counted. kUnavailable: the interface is
  /// down or gone. kMalformed: no frame can look like this.
  Status Send(const can::Frame& frame);

  /// The stamp is the time of reading, on the clock of Now().
  bool Receive(can::Frame& frame);

  /// What went wrong last: the call and the system's words. Valid until the next failure.
  std::string_view error_text() const { return error_; }
  int error_number() const { return errno_; }
  /// False since the interface has gone down or away, until a frame gets through again. One that
  /// was taken out of the system is back only for a new Open().
  bool healthy() const { return healthy_; }
  std::uint64_t tx() const { return tx_; }
  std::uint64_t tx_dropped() const { return tx_dropped_; }
  std::uint64_t rx() const { return rx_; }
  /// Frames that came while the receive queue was full, as far as a later frame has told.
  std::uint64_t rx_dropped() const { return rx_dropped_; }

 private:
  Status Fail(const char* call, int error);
  /// kOk if `name` is a CAN interface, and up.
  Status Check(const char* name);

  int socket_ = -1;
  bool healthy_ = false;
  int errno_ = 0;
  char error_[128] = "";
  std::uint64_t tx_ = 0;
  std::uint64_t tx_dropped_ = 0;
  std::uint64_t rx_ = 0;
  std::uint64_t rx_dropped_ = 0;
  std::uint32_t rx_overflows_ = 0;  ///< the kernel's count, which rolls over
};

static_assert(can::Bus<SocketCan>);

}  // namespace pipewright
