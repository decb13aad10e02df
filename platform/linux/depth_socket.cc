// SPDX-License-Identifier: MIT
#include "platform/linux/depth_socket.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <span>

namespace pipewright {

void DepthSocket::Close() {
  if (socket_ >= 0) {
    close(socket_);
  }
  socket_ = -1;
  have_ = 0;
}

Status DepthSocket::Lost(const char* why) {
  std::snprintf(error_, sizeof error_, "%s: %s", path_.c_str(), why);
  Close();
  return Status::kUnavailable;
}

Status DepthSocket::Connect(Time now) {
  if (now < next_try_) {
    return Status::kUnavailable;
  }
  next_try_ = now + kRetry;
  sockaddr_un address{};
  if (path_.empty() || path_.size() >= sizeof address.sun_path) {
    return Lost("no path that a socket can have");
  }
  address.sun_family = AF_UNIX;
  path_.copy(address.sun_path, path_.size());
  socket_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket_ < 0 ||
      connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return Lost(std::strerror(errno));
  }
  return Status::kOk;
}

/// Reads what is there, until `size` bytes of the frame have come.
Status DepthSocket::Fill(std::size_t size) {
  while (have_ < size) {
    const ssize_t got = recv(socket_, bytes_.data() + have_, size - have_, MSG_DONTWAIT);
    if (got > 0) {
      have_ += static_cast<std::size_t>(got);
    } else if (got == 0) {
      return Lost("the sender has left");
    } else if (errno == EAGAIN) {
      return Status::kTimeout;
    } else if (errno != EINTR) {
      return Lost(std::strerror(errno));
    }
  }
  return Status::kOk;
}

Status DepthSocket::Poll(Time now, DepthFrame& frame) {
  if (socket_ < 0 && Connect(now) != Status::kOk) {
    return Status::kUnavailable;
  }
  if (const Status status = Fill(kDepthHeadBytes); status != Status::kOk) {
    return status;
  }
  const std::span<const std::uint8_t> bytes(bytes_);
  if (TakeDepthHead(bytes.first<kDepthHeadBytes>(), frame) != Status::kOk) {
    return Lost("what comes is no depth frame");
  }
  const std::size_t pixels = PixelBytes(frame);
  if (const Status status = Fill(kDepthHeadBytes + pixels); status != Status::kOk) {
    return status;
  }
  TakePixels(bytes.subspan(kDepthHeadBytes, pixels), frame);
  have_ = 0;
  return Status::kOk;
}

}  // namespace pipewright
