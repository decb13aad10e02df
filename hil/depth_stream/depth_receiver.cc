// SPDX-License-Identifier: MIT
#include "hil/depth_stream/depth_receiver.h"

#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <chrono>

#include "platform/core/depth_wire.h"

namespace pipewright::hil {

std::string DepthReceiver::Open(const std::string& path) {
  std::string error;
  stream_ = ConnectLocal(path, error);
  bytes_.resize(kDepthHeadBytes + 2 * std::size_t{DepthFrame::kMaxPixels});
  have_ = 0;
  return error;
}

/// Waits at most `patience` for each piece of what is still missing of bytes_[0, size).
Status DepthReceiver::Fill(std::size_t size, Duration patience) {
  const auto patience_ms = std::chrono::duration_cast<std::chrono::milliseconds>(patience);
  while (have_ < size) {
    pollfd wait{.fd = stream_.number(), .events = POLLIN, .revents = 0};
    if (poll(&wait, 1, static_cast<int>(patience_ms.count())) <= 0) {
      return Status::kTimeout;
    }
    const ssize_t got = recv(stream_.number(), bytes_.data() + have_, size - have_, MSG_DONTWAIT);
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) {
      stream_.Reset();
      return Status::kUnavailable;
    }
    have_ += got > 0 ? static_cast<std::size_t>(got) : 0;
  }
  return Status::kOk;
}

Status DepthReceiver::Read(DepthFrame& frame, Duration patience) {
  if (!stream_.open()) {
    return Status::kUnavailable;
  }
  if (const Status status = Fill(kDepthHeadBytes, patience); status != Status::kOk) {
    return status;
  }
  const std::span<const std::uint8_t> bytes(bytes_);
  if (TakeDepthHead(bytes.first<kDepthHeadBytes>(), frame) != Status::kOk) {
    stream_.Reset();
    return Status::kMalformed;
  }
  const std::size_t pixels = PixelBytes(frame);
  if (const Status status = Fill(kDepthHeadBytes + pixels, patience); status != Status::kOk) {
    return status;
  }
  TakePixels(bytes.subspan(kDepthHeadBytes, pixels), frame);
  have_ = 0;
  return Status::kOk;
}

}  // namespace pipewright::hil
