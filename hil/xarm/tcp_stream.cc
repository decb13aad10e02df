// SPDX-License-Identifier: MIT
#include "hil/xarm/tcp_stream.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace pipewright::hil {
namespace {

constexpr int kBacklog = 8;

bool Address(const std::string& text, int port, sockaddr_in& address) {
  address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return inet_pton(AF_INET, text.c_str(), &address.sin_addr) == 1;
}

const sockaddr* Generic(const sockaddr_in& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

/// A request of 41 bytes is not to wait for others.
void SendAtOnce(const Descriptor& socket) {
  const int on = 1;
  setsockopt(socket.number(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

}  // namespace

TcpStream::TcpStream(Descriptor connected) : socket_(std::move(connected)) { SendAtOnce(socket_); }

Status TcpStream::Connect(const std::string& address, int port) {
  *this = TcpStream();
  sockaddr_in to{};
  if (!Address(address, port, to)) {
    return Status::kMalformed;
  }
  socket_ = Descriptor(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket_.open()) {
    return Status::kUnavailable;
  }
  SendAtOnce(socket_);
  connecting_ = true;
  if (connect(socket_.number(), Generic(to), sizeof to) != 0 && errno != EINPROGRESS) {
    Close();
    return Status::kUnavailable;
  }
  return Status::kOk;
}

void TcpStream::Close() {
  socket_.Reset();
  connecting_ = false;
}

void TcpStream::Poll() {
  if (connecting_) {
    pollfd ready{.fd = socket_.number(), .events = POLLOUT, .revents = 0};
    if (poll(&ready, 1, 0) <= 0) {
      return;
    }
    int error = 0;
    socklen_t size = sizeof error;
    getsockopt(socket_.number(), SOL_SOCKET, SO_ERROR, &error, &size);
    if (error != 0) {
      return Close();
    }
    connecting_ = false;
  }
  while (open() && have_ < kRoom) {
    const ssize_t got = recv(socket_.number(), room_.data() + have_, kRoom - have_, MSG_DONTWAIT);
    if (got > 0) {
      have_ += static_cast<std::size_t>(got);
      read_ += static_cast<std::uint64_t>(got);
    } else if (got < 0 && (errno == EAGAIN || errno == EINTR)) {
      return;
    } else {
      return Close();
    }
  }
}

void TcpStream::Take(std::size_t bytes) {
  std::copy(room_.begin() + static_cast<std::ptrdiff_t>(bytes),
            room_.begin() + static_cast<std::ptrdiff_t>(have_), room_.begin());
  have_ -= bytes;
}

bool TcpStream::Send(std::span<const std::uint8_t> bytes) {
  if (!open()) {
    return false;
  }
  const ssize_t sent =
      send(socket_.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  if (sent != static_cast<ssize_t>(bytes.size())) {
    Close();
    return false;
  }
  sent_ += bytes.size();
  return true;
}

std::uint64_t TcpStream::arrived() const {
  int waiting = 0;
  if (!open() || ioctl(socket_.number(), FIONREAD, &waiting) != 0) {
    waiting = 0;
  }
  return read_ + static_cast<std::uint64_t>(waiting);
}

std::string TcpListener::Open(const std::string& address, int port) {
  sockaddr_in at{};
  const int on = 1;
  socklen_t size = sizeof at;
  const auto fail = [&](const char* why) { return fmt::format("{}:{}: {}", address, port, why); };
  if (!Address(address, port, at)) {
    return fail("not an IPv4 address");
  }
  socket_ = Descriptor(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket_.open() ||
      setsockopt(socket_.number(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
      bind(socket_.number(), Generic(at), sizeof at) != 0 ||
      listen(socket_.number(), kBacklog) != 0 ||
      getsockname(socket_.number(), reinterpret_cast<sockaddr*>(&at), &size) != 0) {
    return fail(std::strerror(errno));
  }
  port_ = ntohs(at.sin_port);
  return "";
}

Descriptor TcpListener::Accept() {
  return Descriptor(accept4(socket_.number(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
}

}  // namespace pipewright::hil
