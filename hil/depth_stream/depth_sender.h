// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hil/depth_stream/local_socket.h"
#include "platform/core/depth_frame.h"

namespace pipewright::hil {

/// A camera's end of a depth stream: a Unix socket that any number of readers connect to, whose end
/// is platform/linux/depth_socket.h. A reader that does not take a frame within 1 s is sent away;
/// the others are not made to wait again.
///
///   DepthSender sender;
///   if (std::string error = sender.Open("/tmp/depth"); !error.empty()) ...
///   sender.Send(frame);
class DepthSender {
 public:
  static constexpr int kPatience_ms = 1000;

  DepthSender() = default;
  ~DepthSender() { Close(); }
  DepthSender(const DepthSender&) = delete;
  DepthSender& operator=(const DepthSender&) = delete;

  /// Takes over a path that a process which is no more has left behind.
  /// @returns an error in words that names the path, or nothing
  std::string Open(const std::string& path);
  /// Sends the readers away and removes the path.
  void Close();

  /// Takes in who has come since.
  bool HasReaders();
  /// To every reader there is.
  void Send(const DepthFrame& frame);

  std::uint64_t readers_seen() const { return readers_seen_; }
  std::uint64_t readers_lost() const { return readers_lost_; }  ///< left, or were too slow

 private:
  void Accept();

  std::string path_;
  Descriptor listener_;
  std::vector<Descriptor> readers_;
  std::vector<std::uint8_t> bytes_;
  std::uint64_t readers_seen_ = 0;
  std::uint64_t readers_lost_ = 0;
};

}  // namespace pipewright::hil
