// SPDX-License-Identifier: MIT
#include "hil/depth_stream/depth_sender.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <span>
#include <utility>

#include "platform/core/depth_wire.h"

namespace pipewright::hil {
namespace {

constexpr int kBacklog = 8;

bool IsSocket(const std::string& path) {
  struct stat about {};
  return lstat(path.c_str(), &about) == 0 && S_ISSOCK(about.st_mode);
}

/// False: the reader is gone, or took too long.
bool SendAll(int socket, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(sent));
      continue;
    }
    pollfd wait{.fd = socket, .events = POLLOUT, .revents = 0};
    const bool full = sent < 0 && (errno == EAGAIN || errno == EINTR);
    if (!full || poll(&wait, 1, DepthSender::kPatience_ms) <= 0) {
      return false;
    }
  }
  return true;
}

}  // namespace

std::string DepthSender::Open(const std::string& path) {
  Close();
  sockaddr_un address{};
  if (std::string error = LocalAddress(path, address); !error.empty()) {
    return error;
  }
  std::string nobody;
  if (IsSocket(path)) {
    if (ConnectLocal(path, nobody).open()) {
      return fmt::format("{}: another process sends there", path);
    }
    unlink(path.c_str());
  }
  Descriptor listener(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!listener.open() ||
      bind(listener.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      listen(listener.number(), kBacklog) != 0) {
    return fmt::format("{}: {}", path, std::strerror(errno));
  }
  listener_ = std::move(listener);
  path_ = path;
  return "";
}

void DepthSender::Close() {
  readers_.clear();
  if (listener_.open()) {
    unlink(path_.c_str());
  }
  listener_.Reset();
}

void DepthSender::Accept() {
  while (listener_.open()) {
    Descriptor reader(accept4(listener_.number(), nullptr, nullptr, SOCK_CLOEXEC));
    if (!reader.open()) {
      return;
    }
    ++readers_seen_;
    readers_.push_back(std::move(reader));
  }
}

bool DepthSender::HasReaders() {
  Accept();
  return !readers_.empty();
}

void DepthSender::Send(const DepthFrame& frame) {
  if (!HasReaders()) {
    return;
  }
  bytes_.resize(kDepthHeadBytes + PixelBytes(frame));
  PutDepthFrame(frame, bytes_);
  const auto gone = std::erase_if(
      readers_, [this](const Descriptor& reader) { return !SendAll(reader.number(), bytes_); });
  readers_lost_ += gone;
}

}  // namespace pipewright::hil
