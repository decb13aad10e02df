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
/// the controller are received as frames too. Not for sharing between threads.
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
  /// no such interface, it is down, or it is not ours to open; error_text() says which.
  Status Open(std::string_view interface);
  void Close();
  bool is_open() const { return socket_ >= 0; }

  /// kFull: the transmit queue is full (ENOBUFS, EAGAIN); counted. kUnavailable: the interface is
  /// down or gone. kMalformed: no frame can look like this.
  Status Send(const can::Frame& frame);

  /// The stamp is the time of reading, on the clock of Now().
  bool Receive(can::Frame& frame);

  /// What went wrong last: the call and the system's words. Valid until the next failure.
  std::string_view error_text() const { return error_; }
  int error_number() const { return errno_; }
  /// False once the interface has gone down or away; Open() may be tried again.
  bool healthy() const { return healthy_; }
  std::uint64_t tx() const { return tx_; }
  std::uint64_t tx_dropped() const { return tx_dropped_; }
  std::uint64_t rx() const { return rx_; }

 private:
  Status Fail(const char* call, int error);

  int socket_ = -1;
  bool healthy_ = false;
  int errno_ = 0;
  char error_[128] = "";
  std::uint64_t tx_ = 0;
  std::uint64_t tx_dropped_ = 0;
  std::uint64_t rx_ = 0;
};

static_assert(can::Bus<SocketCan>);

}  // namespace pipewright
