// SPDX-License-Identifier: MIT
// Replays a recording of control cycles and compares the frames sent with those recorded. The same
// source on every machine, from a desk to a bare microcontroller: no exceptions, no streams.
//
//   bench_control --record FILE [--cycles N] [--rate HZ] [--seed N]
//   replay_cycles FILE [--lsb N] [--sent FILE]
//
// Exit code 0: every frame the same, up to N least significant bits of its quantities (default 0);
// 1: not; 2: bad input.
#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/timing/replay/replay.h"

namespace pipewright::timing {
namespace {

constexpr char kUsage[] = "usage: replay_cycles RECORDING [--lsb N] [--sent FILE]\n";

struct Options {
  const char* recording = nullptr;
  const char* sent = nullptr;
  std::int64_t lsb = 0;
};

bool ParseLsb(const char* text, std::int64_t& lsb) {
  char* end = nullptr;
  lsb = std::strtol(text, &end, 10);
  return end != text && *end == '\0' && lsb >= 0;
}

bool Parse(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; ++i) {
    const bool more = i + 1 < argc;
    if (std::strcmp(argv[i], "--lsb") == 0 && more) {
      if (!ParseLsb(argv[++i], options.lsb)) {
        return false;
      }
    } else if (std::strcmp(argv[i], "--sent") == 0 && more) {
      options.sent = argv[++i];
    } else if (argv[i][0] != '-' && options.recording == nullptr) {
      options.recording = argv[i];
    } else {
      return false;
    }
  }
  return options.recording != nullptr;
}

void Print(const ReplayResult& r) {
  std::printf("cycles            %d\n", r.cycles);
  std::printf("counted           %d\n", r.counted);
  std::printf("of_120_rows       %d\n", r.many_rows);
  std::printf("frames            %d\n", r.frames);
  std::printf("frames_different  %d\n", r.different);
  std::printf("incomparable      %d\n", r.incomparable);
  std::printf("largest_lsb       %ld\n", static_cast<long>(r.largest_lsb));
  std::printf("first_different   %d\n", r.first_different);
  std::printf("stack_bytes       %d\n", r.stack_bytes);
  std::printf("robot_bytes       %d\n", r.robot_bytes);
  std::printf("field_bytes       %ld\n", static_cast<long>(r.field_bytes));
}

std::FILE* Open(const char* path, const char* mode) {
  std::FILE* file = std::fopen(path, mode);
  if (file == nullptr) {
    std::fprintf(stderr, "replay_cycles: %s: %s\n", path, std::strerror(errno));
  }
  return file;
}

int Run(const Options& options) {
  std::FILE* file = Open(options.recording, "rb");
  if (file == nullptr) {
    return 2;
  }
  std::FILE* sent = options.sent == nullptr ? nullptr : Open(options.sent, "w");
  if (options.sent != nullptr && sent == nullptr) {
    std::fclose(file);
    return 2;
  }
  static Replay replay;  // on no small machine's stack
  RecordingReader recording(file);
  ReplayResult result;
  const bool good = replay.Run(recording, sent, result);
  std::fclose(file);
  const bool written = sent == nullptr || std::fclose(sent) == 0;
  if (!good) {
    const char* problem = recording.problem();
    std::fprintf(stderr, "replay_cycles: %s: %s, at byte %ld\n", options.recording,
                 problem != nullptr ? problem : "its configuration is refused",
                 static_cast<long>(recording.offset()));
    return 2;
  }
  if (!written) {
    std::fprintf(stderr, "replay_cycles: %s was not written whole\n", options.sent);
    return 2;
  }
  Print(result);
  return result.counted > 0 && result.Within(options.lsb) ? 0 : 1;
}

}  // namespace
}  // namespace pipewright::timing

int main(int argc, char** argv) {
  pipewright::timing::Options options;
  if (!pipewright::timing::Parse(argc, argv, options)) {
    std::fputs(pipewright::timing::kUsage, stderr);
    return 2;
  }
  return pipewright::timing::Run(options);
}
