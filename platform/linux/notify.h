// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "platform/core/status.h"
#include "platform/core/time.h"

namespace pipewright {

/// A service's word to systemd, sd_notify(3)'s protocol: datagrams of "KEY=VALUE" lines to the
/// socket that it names in the environment. Never waits. No heap.
///
///   ServiceNotify notify = ServiceNotify::OfEnvironment();
///   notify.Send("READY=1\nSTATUS=idle");
///   if (notify.watchdog() > Duration::zero()) ...   // send "WATCHDOG=1" more often than that
class ServiceNotify {
 public:
  /// Tells nobody.
  ServiceNotify() = default;
  /// NOTIFY_SOCKET and, where WATCHDOG_PID is this process's or not set, WATCHDOG_USEC.
  static ServiceNotify OfEnvironment();
  /// @param path  of a datagram socket; a leading '@' stands for one without a file
  ServiceNotify(std::string_view path, Duration watchdog);
  ~ServiceNotify();
  ServiceNotify(ServiceNotify&& other) noexcept;
  ServiceNotify& operator=(ServiceNotify&&) = delete;

  /// Whether anybody listens.
  bool active() const { return socket_ >= 0; }
  /// Silence for so long, and the service is ended; zero: nobody watches.
  Duration watchdog() const { return watchdog_; }

  /// kUnavailable: nobody listens, or not now.
  Status Send(std::string_view lines) const;

 private:
  int socket_ = -1;
  Duration watchdog_{};
};

}  // namespace pipewright
