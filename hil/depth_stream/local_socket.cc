// SPDX-License-Identifier: MIT
#include "hil/depth_stream/local_socket.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace pipewright::hil {

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  if (this != &other) {
    Reset();
    number_ = std::exchange(other.number_, -1);
  }
  return *this;
}

void Descriptor::Reset() {
  if (number_ >= 0) {
    close(number_);
  }
  number_ = -1;
}

std::string LocalAddress(const std::string& path, sockaddr_un& address) {
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    return fmt::format("{}: a socket's path has 1 to {} characters", path,
                       sizeof address.sun_path - 1);
  }
  address = {};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, path.size());
  return "";
}

Descriptor ConnectLocal(const std::string& path, std::string& error) {
  sockaddr_un address{};
  error = LocalAddress(path, address);
  if (!error.empty()) {
    return {};
  }
  Descriptor stream(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (!stream.open() ||
      connect(stream.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    error = fmt::format("{}: {}", path, std::strerror(errno));
    return {};
  }
  return stream;
}

}  // namespace pipewright::hil
