// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "platform/core/status.h"
#include "platform/core/time.h"

namespace pipewright {

/// Who is at the other end, by the kernel's word (SO_PEERCRED).
struct Peer {
  int pid = 0;
  unsigned uid = 0;
  unsigned gid = 0;
};

/// A Unix stream socket at which a few clients each send lines and get one line for each. Never
/// waits, and no client can make it: the memory is fixed, a poll serves each client one line, and
/// one that sends too much, reads too little or says nothing for long is sent away.
///
///   LineServer server;
///   if (server.Open("/run/pipewright/status.sock") != Status::kOk) return
///   Complain(server.error_text()); server.Poll(now, [&](std::string_view line, const Peer& peer,
///   std::span<char> out) {
///     return Answer(line, peer, out);   // bytes written, at most out.size()
///   });
class LineServer {
 public:
  static constexpr int kClients = 8;
  static constexpr int kLineBytes = 128;     ///< of a request, its end included
  static constexpr int kAnswerBytes = 2048;  ///< likewise
  static constexpr Duration kPatience = std::chrono::seconds(5);  ///< with a client that is silent

  LineServer() = default;
  ~LineServer() { Close(); }
  LineServer(const LineServer&) = delete;
  LineServer& operator=(const LineServer&) = delete;

  /// Owner and group may connect (0660), no others. A path that a process which is no more has left
  /// is taken over. kUnavailable: error_text() says why.
  Status Open(const std::string& path);
  void Close();  ///< and removes the path
  std::string_view error_text() const { return error_; }

  template <typename Answer>
  void Poll(Time now, Answer&& answer) {
    Accept(now);
    for (Client& client : clients_) {
      std::string_view line;
      if (!Read(client, now, line)) {
        continue;
      }
      const std::size_t size =
          answer(line, client.peer, std::span<char>(out_).first(kAnswerBytes - 1));
      Reply(client, size);
    }
  }

  int clients() const;
  std::uint64_t refused() const { return refused_; }  ///< no room, or not as agreed

 private:
  struct Client {
    int socket = -1;
    Peer peer;
    Time heard{};
    std::array<char, kLineBytes> line{};
    std::size_t have = 0;
    std::size_t taken = 0;  ///< of what it has: the line that was answered
  };

  Status Fail(const char* call);
  void Accept(Time now);
  bool Read(Client& client, Time now, std::string_view& line);
  void Reply(Client& client, std::size_t size);
  void Refuse(Client& client, std::string_view why);
  static void Drop(Client& client);

  int socket_ = -1;
  std::string path_;
  std::string error_;
  std::array<Client, kClients> clients_;
  std::array<char, kAnswerBytes> out_{};
  std::uint64_t refused_ = 0;
};

}  // namespace pipewright
