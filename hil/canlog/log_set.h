// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hil/canlog/frame_filter.h"
#include "hil/canlog/log_reader.h"

namespace pipewright::hil {

/// What was read of one file.
struct FileRead {
  std::string path;
  std::string format;
  std::string packing;
  std::uint64_t bytes = 0;   ///< unpacked
  std::uint64_t frames = 0;  ///< before the filter
  LogProblems problems;
};

/// The frames of several files, one file after the other as parts of one log, that a filter wants.
class LogSet {
 public:
  /// Called as reading goes on, with bytes of the files read and in all (0: not known).
  using Progress = std::function<void(std::uint64_t, std::uint64_t)>;

  LogSet() = default;
  LogSet(std::vector<std::string> paths, const LogOptions& options, const FrameFilter& filter);

  void set_progress(Progress progress) { progress_ = std::move(progress); }

  /// The next frames; none: the end, or error(). Valid until the next call.
  std::span<const LogFrame> Next();

  /// That a file cannot be read at all, in words; empty if all can.
  const std::string& error() const { return error_; }
  const std::vector<FileRead>& files() const { return files_; }
  const ChannelNames& channels() const { return channels_; }
  /// Whether every line, packet and file was whole.
  bool whole() const;

 private:
  bool OpenNext();
  void CloseFile();

  std::vector<std::string> paths_;
  LogOptions options_;
  FrameFilter filter_;
  Progress progress_;
  ChannelNames channels_;
  std::unique_ptr<LogReader> reader_;
  std::vector<FileRead> files_;
  std::string error_;
  std::uint64_t bytes_before_ = 0;  ///< of the files read already
  std::uint64_t bytes_in_all_ = 0;
};

}  // namespace pipewright::hil
