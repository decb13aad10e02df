// SPDX-License-Identifier: MIT
#include "platform/linux/latch_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

namespace pipewright {
namespace {

constexpr std::size_t kMost = 200;

std::string Plain(std::string text) {
  for (char& c : text) {
    c = ' ' <= c && c <= '~' && c != '"' && c != '\\' ? c : ' ';
  }
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

}  // namespace

std::string LatchFile::Read() const {
  const int file = path_.empty() ? -1 : open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) {
    return path_.empty() || errno == ENOENT ? "" : "the latch cannot be read";
  }
  std::string text(kMost, '\0');
  const ssize_t size = read(file, text.data(), text.size());
  close(file);
  text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  const std::string reason = Plain(text);
  return reason.empty() ? "the latch is empty" : reason;
}

Status LatchFile::Set(std::string_view reason) const {
  if (path_.empty()) {
    return Status::kOk;
  }
  const int file = open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0640);
  if (file < 0) {
    return Status::kUnavailable;
  }
  const std::string_view line = reason.substr(0, kMost);
  const bool written = write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size()) &&
                       fsync(file) == 0;
  close(file);
  return written ? Status::kOk : Status::kUnavailable;
}

Status LatchFile::Clear() const {
  const bool gone = path_.empty() || unlink(path_.c_str()) == 0 || errno == ENOENT;
  return gone ? Status::kOk : Status::kUnavailable;
}

}  // namespace pipewright
