// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hil/depth_stream/local_socket.h"
#include "platform/core/depth_frame.h"
#include "platform/core/status.h"

namespace pipewright::hil {

/// The reading end of a depth stream.
class DepthReceiver {
 public:
  /// @returns an error in words that names the path, or nothing
  std::string Open(const std::string& path);

  /// The next frame, its stamp on the clock of Now(). kTimeout: none within `patience`; a frame
  /// that has begun goes on with the next call. kMalformed: what comes is no frame. kUnavailable:
  /// the other side has left. After these two the stream is closed. `frame` may be written in any
  /// case.
  Status Read(DepthFrame& frame, Duration patience);

 private:
  Status Fill(std::size_t size, Duration patience);

  Descriptor stream_;
  std::vector<std::uint8_t> bytes_;
  std::size_t have_ = 0;  ///< of bytes_
};

}  // namespace pipewright::hil
