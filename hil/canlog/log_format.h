// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "hil/canlog/byte_window.h"
#include "hil/canlog/channel_names.h"
#include "hil/canlog/log_frame.h"
#include "hil/canlog/log_problems.h"

namespace pipewright::hil {

/// What a reader of one format works with.
struct LogInput {
  ByteWindow& bytes;
  ChannelNames& channels;
  LogProblems& problems;
  bool whole_lines = false;  ///< of LogOptions
};

/// A reader of one format: takes frames from front to back, in constant memory.
class LogFormat {
 public:
  virtual ~LogFormat() = default;
  LogFormat() = default;
  LogFormat(const LogFormat&) = delete;
  LogFormat& operator=(const LogFormat&) = delete;

  virtual const char* name() const = 0;
  /// Fills `out` from the front; fewer frames than asked for only at the end of the log.
  virtual std::size_t Fill(LogInput& in, std::span<LogFrame> out) = 0;
};

}  // namespace pipewright::hil
