// SPDX-License-Identifier: MIT
#include "hil/canlog/log_set.h"

#include <algorithm>
#include <filesystem>

namespace pipewright::hil {

LogSet::LogSet(std::vector<std::string> paths, const LogOptions& options, const FrameFilter& filter)
    : paths_(std::move(paths)), options_(options), filter_(filter) {
  for (const std::string& path : paths_) {
    std::error_code failed;
    const std::uintmax_t bytes = std::filesystem::file_size(path, failed);
    if (failed) {  // standard input, a pipe, or no file at all
      bytes_in_all_ = 0;
      break;
    }
    bytes_in_all_ += bytes;
  }
}

bool LogSet::OpenNext() {
  if (files_.size() == paths_.size() || !error_.empty()) {
    return false;
  }
  FileRead file;
  file.path = paths_[files_.size()];
  reader_ = std::make_unique<LogReader>(channels_);
  error_ = reader_->Open(file.path, options_);
  if (!error_.empty()) {
    return false;
  }
  file.format = reader_->format();
  file.packing = reader_->packing();
  files_.push_back(std::move(file));
  return true;
}

void LogSet::CloseFile() {
  FileRead& file = files_.back();
  file.bytes = reader_->bytes();
  file.problems = reader_->problems();
  bytes_before_ += reader_->file_position();
  reader_.reset();
}

std::span<const LogFrame> LogSet::Next() {
  while (reader_ || OpenNext()) {
    const std::span<LogFrame> frames = reader_->Next();
    files_.back().frames += frames.size();
    if (progress_) {
      progress_(bytes_before_ + reader_->file_position(), bytes_in_all_);
    }
    if (frames.empty()) {
      CloseFile();
      continue;
    }
    if (const std::size_t kept = filter_.Keep(frames); kept > 0) {
      return frames.first(kept);
    }
  }
  return {};
}

bool LogSet::whole() const {
  return std::all_of(files_.begin(), files_.end(),
                     [](const FileRead& file) { return file.problems.none(); });
}

}  // namespace pipewright::hil
