// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hil/canlog/byte_source.h"
#include "hil/canlog/byte_window.h"
#include "hil/canlog/log_format.h"

namespace pipewright::hil {

struct LogOptions {
  bool deltas = false;       ///< candump's stamps are times between frames (-t d)
  bool whole_lines = false;  ///< a text's last line counts only with its line feed
};

/// Reads one log from front to back, whatever its format: candump -L, candump, ASC, pcap or
/// pcapng, plain or packed by gz or zstd. Its first bytes tell. Memory is that of the window, the
/// block and the unpacker; nothing is allocated per frame.
///
///   LogReader log(channels);
///   if (const std::string error = log.Open(path, {}); !error.empty()) return Fail(error);
///   for (std::span<const LogFrame> block = log.Next(); !block.empty(); block = log.Next()) {
///     Use(block);
///   }
///   Tell(log.problems());
///
/// A text's last line needs no line feed if it makes sense: a candump -L that was cut between two
/// bytes of a payload ends with a shorter frame, and does not tell. Who must know asks for
/// whole_lines.
class LogReader {
 public:
  /// Channels of several logs share their numbers.
  explicit LogReader(ChannelNames& channels);

  /// @param path  "-": standard input
  /// @returns an error in words that names the path, or nothing. An empty file is a log of nothing;
  ///          one that ends within its first line is one that ends early.
  std::string Open(const std::string& path, const LogOptions& options);
  /// The same of a stream that is open for reading, which it takes over and calls `name`.
  std::string Open(std::FILE* file, const std::string& name, const LogOptions& options);

  /// The next frames in the order of the log; none: its end. Valid until the next call.
  std::span<LogFrame> Next();

  const LogProblems& problems() const { return problems_; }
  const char* format() const { return format_ ? format_->name() : "empty"; }
  const char* packing() const { return source_.packing(); }
  /// Bytes of the file read so far, and in all; 0: not known.
  std::uint64_t file_position() const { return source_.file_position(); }
  std::uint64_t file_size() const { return source_.file_size(); }
  /// Bytes taken after unpacking.
  std::uint64_t bytes() const { return window_.position(); }

 private:
  std::string Begin(const std::string& name, const LogOptions& options);

  ChannelNames& channels_;
  ByteSource source_;
  ByteWindow window_{source_};
  LogProblems problems_;
  std::unique_ptr<LogFormat> format_;
  bool whole_lines_ = false;
  std::vector<LogFrame> block_;
};

}  // namespace pipewright::hil
