// SPDX-License-Identifier: MIT
#include "platform/linux/journal.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace pipewright {
namespace {

constexpr int kMost = 1024;

int Level(Severity severity) {
  switch (severity) {
    case Severity::kError:
      return 3;
    case Severity::kWarning:
      return 4;
    case Severity::kNotice:
      return 5;
    case Severity::kInfo:
      return 6;
  }
  return 6;
}

}  // namespace

void Say(Severity severity, std::string_view what) {
  char line[kMost + 32];
  const int size = static_cast<int>(what.size() < kMost ? what.size() : kMost);
  const int written =
      std::getenv("JOURNAL_STREAM") != nullptr
          ? std::snprintf(line, sizeof line, "<%d>%.*s\n", Level(severity), size, what.data())
          : std::snprintf(line, sizeof line, "pipewrightd: %.*s\n", size, what.data());
  // One write, so that lines of several threads stay whole. A journal that is gone hurts nobody.
  [[maybe_unused]] const ssize_t ignored =
      write(STDERR_FILENO, line, static_cast<std::size_t>(written));
}

}  // namespace pipewright
