// SPDX-License-Identifier: MIT
// F14: logs that are damaged.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "hil/canlog/log_reader.h"
#include "tests/bench/faults/rows.h"
#include "tests/support/can_logs.h"

namespace pipewright::bench {
namespace {

struct ReadLog {
  bool opened = false;
  bool ended_early = false;
  std::uint64_t malformed = 0;
  std::vector<hil::LogFrame> frames;
};

ReadLog ReadAll(std::string bytes) {
  ReadLog read;
  hil::ChannelNames channels;
  hil::LogReader log(channels);
  std::FILE* file = fmemopen(bytes.data(), bytes.size(), "r");
  if (file == nullptr || !log.Open(file, "log", {.whole_lines = true}).empty()) {
    return read;
  }
  read.opened = true;
  for (auto block = log.Next(); !block.empty(); block = log.Next()) {
    read.frames.insert(read.frames.end(), block.begin(), block.end());
  }
  read.malformed = log.problems().malformed();
  read.ended_early = !log.problems().end().empty();
  return read;
}

bool Same(const hil::LogFrame& a, const hil::LogFrame& b) {
  return a.id == b.id && a.length == b.length && a.stamp_ns == b.stamp_ns &&
         std::equal(a.data.begin(), a.data.begin() + a.length, b.data.begin());
}

/// The frames of a cut log are the first of the whole one's, all that are whole.
bool IsBeginning(const ReadLog& cut, const ReadLog& whole) {
  return cut.frames.size() <= whole.frames.size() &&
         std::equal(cut.frames.begin(), cut.frames.end(), whole.frames.begin(), Same);
}

}  // namespace

Tally LogsDamaged(std::uint64_t n, std::uint64_t seed) {
  Tally tally;
  const std::vector<hil::LogFrame> frames = test::RandomFrames(24, seed);
  for (const test::NamedLog& form : test::InEveryFormat(frames)) {
    const ReadLog whole = ReadAll(form.bytes);
    std::size_t before = 0;
    for (std::size_t at = 1; at < form.bytes.size() && tally.n() < n; ++at) {
      const ReadLog cut = ReadAll(form.bytes.substr(0, at));
      const bool right = IsBeginning(cut, whole) && cut.frames.size() >= before;
      before = std::max(before, cut.frames.size());
      tally.Add(right ? Outcome::kMasked : Outcome::kWrong);
      if (!right) {
        tally.Note(
            fmt::format("{} cut after {} bytes: not the beginning of the whole", form.name, at));
      }
    }
    for (std::size_t at = 0; at < form.bytes.size() && tally.n() < n; ++at) {
      std::string damaged = form.bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << at % 8));
      const ReadLog read = ReadAll(damaged);
      // A separator flipped in or out makes one record more, or two of one. Formats with lengths
      // may take the rest for one record.
      const bool right = read.frames.size() <= whole.frames.size() + 1;
      tally.Add(right ? Outcome::kMasked : Outcome::kWrong);
      if (!right) {
        tally.Note(fmt::format("{} with byte {} flipped: {} frames of {}", form.name, at,
                               read.frames.size(), whole.frames.size()));
      }
    }
  }
  tally.Note("a full disk, and what replay makes of cut runs: tests/mission/replay_test.cc");
  return tally;
}

}  // namespace pipewright::bench
