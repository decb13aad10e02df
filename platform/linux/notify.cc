// SPDX-License-Identifier: MIT
#include "platform/linux/notify.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace pipewright {
namespace {

std::string_view Environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string_view() : value;
}

/// 0 for what is no whole number.
std::int64_t Whole(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? value : 0;
}

}  // namespace

ServiceNotify ServiceNotify::OfEnvironment() {
  const std::string_view pid = Environment("WATCHDOG_PID");
  const bool ours = pid.empty() || Whole(pid) == getpid();
  const std::int64_t usec = ours ? Whole(Environment("WATCHDOG_USEC")) : 0;
  return ServiceNotify(Environment("NOTIFY_SOCKET"),
                       usec > 0 ? std::chrono::microseconds(usec) : Duration::zero());
}

ServiceNotify::ServiceNotify(std::string_view path, Duration watchdog) : watchdog_(watchdog) {
  sockaddr_un address{};
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    return;
  }
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, path.size());
  if (path.front() == '@') {
    address.sun_path[0] = '\0';
  }
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket_ >= 0 && connect(socket_, reinterpret_cast<const sockaddr*>(&address), size) != 0) {
    close(socket_);
    socket_ = -1;
  }
}

ServiceNotify::ServiceNotify(ServiceNotify&& other) noexcept
    : socket_(other.socket_), watchdog_(other.watchdog_) {
  other.socket_ = -1;
}

ServiceNotify::~ServiceNotify() {
  if (socket_ >= 0) {
    close(socket_);
  }
}

Status ServiceNotify::Send(std::string_view lines) const {
  if (socket_ < 0) {
    return Status::kUnavailable;
  }
  const ssize_t sent = send(socket_, lines.data(), lines.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  return sent == static_cast<ssize_t>(lines.size()) ? Status::kOk : Status::kUnavailable;
}

}  // namespace pipewright
