// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "hil/depth_stream/local_socket.h"
#include "platform/core/status.h"

namespace pipewright::hil {

/// A TCP connection that never waits, with room for kRoom bytes that came and are not taken yet.
/// It is closed by the first error, and by a peer that does not read: what was to be sent has no
/// meaning later.
class TcpStream {
 public:
  static constexpr std::size_t kRoom = 8192;

  TcpStream() = default;
  explicit TcpStream(Descriptor connected);

  /// Begins to connect; Poll() until it is open() or closed.
  /// @param address  IPv4, in figures: a name would have to be waited for
  /// @returns kMalformed: no address; kUnavailable: no socket
  Status Connect(const std::string& address, int port);
  /// Notes that it connected or closed, and takes what has come.
  void Poll();
  void Close();

  bool connecting() const { return connecting_; }
  bool open() const { return socket_.open() && !connecting_; }

  /// What has come; of a stream that has closed, too.
  std::span<const std::uint8_t> received() const { return {room_.data(), have_}; }
  void Take(std::size_t bytes);

  /// All of it, or it is closed and false.
  bool Send(std::span<const std::uint8_t> bytes);

  std::uint64_t sent() const { return sent_; }
  /// Bytes that have come so far: those not read from the kernel yet, too.
  std::uint64_t arrived() const;

 private:
  Descriptor socket_;
  bool connecting_ = false;
  std::array<std::uint8_t, kRoom> room_{};
  std::size_t have_ = 0;
  std::uint64_t sent_ = 0;
  std::uint64_t read_ = 0;
};

/// Where TCP connections come in.
class TcpListener {
 public:
  /// @param port  0: any that is free
  /// @returns an error that names the address and the reason, or nothing
  std::string Open(const std::string& address, int port);
  int port() const { return port_; }
  /// The next connection, or none.
  Descriptor Accept();

 private:
  Descriptor socket_;
  int port_ = 0;
};

}  // namespace pipewright::hil
