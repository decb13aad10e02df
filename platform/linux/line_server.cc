// SPDX-License-Identifier: MIT
#include "platform/linux/line_server.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace pipewright {
namespace {

constexpr mode_t kOwnerAndGroup = 0117;  ///< the bits that a file of 0660 lacks

/// Whether somebody takes connections there.
bool Answers(const sockaddr_un& address) {
  const int probe = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const bool answers = probe >= 0 && (connect(probe, reinterpret_cast<const sockaddr*>(&address),
                                              sizeof address) == 0 ||
                                      errno == EAGAIN);
  if (probe >= 0) {
    close(probe);
  }
  return answers;
}

bool SendAll(int socket, std::string_view text) {
  return send(socket, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT) ==
         static_cast<ssize_t>(text.size());
}

}  // namespace

Status LineServer::Fail(const char* call) {
  error_ = path_ + ": " + call + ": " + std::strerror(errno);
  path_.clear();  // not ours to remove
  Close();
  return Status::kUnavailable;
}

Status LineServer::Open(const std::string& path) {
  Close();
  path_ = path;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    errno = ENAMETOOLONG;
    return Fail("socket");
  }
  path.copy(address.sun_path, path.size());
  struct stat about {};
  if (lstat(path.c_str(), &about) == 0) {
    if (!S_ISSOCK(about.st_mode) || Answers(address)) {
      errno = EADDRINUSE;
      return Fail(S_ISSOCK(about.st_mode) ? "another process answers there" : "not a socket");
    }
    unlink(path.c_str());
  }
  socket_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket_ < 0) {
    return Fail("socket");
  }
  const mode_t before = umask(kOwnerAndGroup);
  const int bound = bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  umask(before);
  if (bound != 0) {
    return Fail("bind");
  }
  return listen(socket_, kClients) == 0 ? Status::kOk : Fail("listen");
}

void LineServer::Close() {
  std::for_each(clients_.begin(), clients_.end(), Drop);
  if (socket_ >= 0) {
    close(socket_);
    if (!path_.empty()) {
      unlink(path_.c_str());
    }
  }
  socket_ = -1;
}

void LineServer::Drop(Client& client) {
  if (client.socket >= 0) {
    close(client.socket);
  }
  client = Client{};
}

int LineServer::clients() const {
  return static_cast<int>(std::count_if(clients_.begin(), clients_.end(),
                                        [](const Client& c) { return c.socket >= 0; }));
}

void LineServer::Refuse(Client& client, std::string_view why) {
  ++refused_;
  SendAll(client.socket, why);
  Drop(client);
}

void LineServer::Accept(Time now) {
  // As many as there is room for, and one more to be told so.
  for (int i = 0; i <= kClients && socket_ >= 0; ++i) {
    Client client;
    client.socket = accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (client.socket < 0) {
      return;
    }
    client.heard = now;
    ucred credentials{};
    socklen_t size = sizeof credentials;
    if (getsockopt(client.socket, SOL_SOCKET, SO_PEERCRED, &credentials, &size) == 0) {
      client.peer = {credentials.pid, credentials.uid, credentials.gid};
    }
    const auto free = std::find_if(clients_.begin(), clients_.end(),
                                   [](const Client& c) { return c.socket < 0; });
    if (free == clients_.end()) {
      Refuse(client, "{\"ok\":false,\"error\":\"too many clients\"}\n");
    } else {
      *free = client;
    }
  }
}

bool LineServer::Read(Client& client, Time now, std::string_view& line) {
  if (client.socket < 0) {
    return false;
  }
  // What was answered makes room.
  std::copy(client.line.begin() + client.taken, client.line.begin() + client.have,
            client.line.begin());
  client.have -= client.taken;
  client.taken = 0;
  const ssize_t got = recv(client.socket, client.line.data() + client.have,
                           client.line.size() - client.have, MSG_DONTWAIT);
  if (got > 0) {
    client.have += static_cast<std::size_t>(got);
    client.heard = now;
  }
  const auto end = client.line.begin() + client.have;
  const auto newline = std::find(client.line.begin(), end, '\n');
  if (newline != end) {
    line = std::string_view(client.line.data(),
                            static_cast<std::size_t>(newline - client.line.begin()));
    client.taken = line.size() + 1;
    return true;
  }
  const bool gone = (got == 0 && client.have < client.line.size()) ||
                    (got < 0 && errno != EAGAIN && errno != EINTR);
  if (client.have == client.line.size()) {
    Refuse(client, "{\"ok\":false,\"error\":\"the request is too long\"}\n");
  } else if (gone) {
    Drop(client);
  } else if (now - client.heard > kPatience) {
    Refuse(client, "{\"ok\":false,\"error\":\"no request came\"}\n");
  }
  return false;
}

void LineServer::Reply(Client& client, std::size_t size) {
  size = std::min<std::size_t>(size, kAnswerBytes - 1);
  out_[size] = '\n';
  if (!SendAll(client.socket, {out_.data(), size + 1})) {
    ++refused_;  // it does not read
    Drop(client);
  }
}

}  // namespace pipewright
