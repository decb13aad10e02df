// SPDX-License-Identifier: MIT
#include "hil/canlog/text_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "hil/canlog/asc_lines.h"
#include "hil/canlog/candump_lines.h"
#include "hil/canlog/line_scanner.h"

namespace pipewright::hil {
namespace {

struct CandumpLogLines {
  static constexpr const char* kName = "candump -L";

  LineMeaning Read(std::string_view line, ChannelNames& channels, LogFrame& frame) const {
    return ReadCandumpLogLine(line, channels, frame);
  }
};

class CandumpLines {
 public:
  static constexpr const char* kName = "candump";

  explicit CandumpLines(bool deltas = false) : deltas_(deltas) {}

  LineMeaning Read(std::string_view line, ChannelNames& channels, LogFrame& frame) {
    const LineMeaning meaning = ReadCandumpLine(line, channels, frame);
    if (deltas_ && meaning.kind == LineMeaning::Kind::kFrame) {
      sum_ns_ += std::min(frame.stamp_ns, std::numeric_limits<std::int64_t>::max() - sum_ns_);
      frame.stamp_ns = sum_ns_;
    }
    return meaning;
  }

 private:
  bool deltas_;
  std::int64_t sum_ns_ = 0;
};

struct Asc : AscLines {
  static constexpr const char* kName = "ASC";
};

/// Whether a line that is none may be the beginning of one: ASC's frames begin with their time.
bool MayBeginAFrame(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  return first == std::string_view::npos || IsDigit(line[first]);
}

template <typename Lines>
class TextLog final : public LogFormat {
 public:
  explicit TextLog(const Lines& lines) : lines_(lines) {}

  const char* name() const override { return Lines::kName; }

  std::size_t Fill(LogInput& in, std::span<LogFrame> out) override {
    std::size_t frames = 0;
    std::string_view line;
    while (frames < out.size()) {
      const ByteWindow::LineKind kind = in.bytes.Line(line);
      if (kind == ByteWindow::LineKind::kWhole) {
        const LineMeaning meaning = lines_.Read(line, in.channels, out[frames]);
        frames += meaning.kind == LineMeaning::Kind::kFrame ? 1 : 0;
        if (meaning.kind == LineMeaning::Kind::kMalformed) {
          in.problems.Malformed(Here(in), meaning.expected, line);
        }
      } else if (kind == ByteWindow::LineKind::kTooLong) {
        in.problems.Malformed(Here(in), "a line of less than 4096 bytes", "");
      } else {
        frames += kind == ByteWindow::LineKind::kCut && TakeLast(in, line, out[frames]) ? 1 : 0;
        break;
      }
    }
    return frames;
  }

 private:
  /// A last line that no line feed ends is whole if it makes sense, unless what it is from was cut.
  bool TakeLast(LogInput& in, std::string_view line, LogFrame& frame) {
    if (in.bytes.source().error().empty() && !in.whole_lines) {
      const LineMeaning meaning = lines_.Read(line, in.channels, frame);
      if (meaning.kind == LineMeaning::Kind::kFrame) {
        return true;
      }
      if (meaning.kind == LineMeaning::Kind::kNothing && !MayBeginAFrame(line)) {
        return false;
      }
    }
    in.problems.EndsEarly(fmt::format("ends within {}", Here(in)));
    return false;
  }

  static std::string Here(const LogInput& in) { return fmt::format("line {}", in.bytes.lines()); }

  Lines lines_;
};

/// What the lines at a log's beginning are, read as one format.
struct Sample {
  bool frame = false;      ///< one is, and those before it are at least not malformed
  bool malformed = false;  ///< one is, before any frame
  int stamped = 0;
  int backward = 0;  ///< stamps below that of the line before
};

template <typename Lines>
Sample Try(std::string_view text, Lines lines) {
  Sample sample;
  ChannelNames channels;
  LogFrame frame;
  std::int64_t before_ns = 0;
  while (!text.empty() && (sample.frame || !sample.malformed)) {
    const std::size_t feed = std::min(text.find('\n'), text.size());
    const bool is_last = feed == text.size();  // perhaps cut: it need not make sense
    std::string_view line = text.substr(0, feed);
    line.remove_suffix(line.ends_with('\r') ? 1 : 0);
    text.remove_prefix(is_last ? feed : feed + 1);
    const LineMeaning meaning = lines.Read(line, channels, frame);
    if (meaning.kind == LineMeaning::Kind::kFrame) {
      sample.frame = true;
      sample.stamped += frame.stamped ? 1 : 0;
      sample.backward += frame.stamped && frame.stamp_ns < before_ns ? 1 : 0;
      before_ns = frame.stamp_ns;
    }
    sample.malformed =
        sample.malformed || (meaning.kind == LineMeaning::Kind::kMalformed && !is_last);
  }
  return sample;
}

bool LooksLikeDeltas(const Sample& sample) { return 10 * sample.backward > sample.stamped; }

constexpr int kMostSkipped = 100;  // lines, until a log is none of ours

/// ASC has a head, so that a log may be known before its first frame.
bool HasAscHead(std::string_view begin) {
  return begin.starts_with("date ") || begin.starts_with("base ") || begin.starts_with("//");
}

}  // namespace

std::unique_ptr<LogFormat> TextFormatOf(std::string_view begin, bool deltas) {
  // Lines that make no sense may come first: the rest still tells what the log is.
  std::string_view text = begin;
  for (int skipped = 0; skipped < kMostSkipped && !text.empty(); ++skipped) {
    if (Try(text, CandumpLogLines()).frame) {
      return std::make_unique<TextLog<CandumpLogLines>>(CandumpLogLines());
    }
    const Sample sample = Try(text, CandumpLines());
    if (sample.frame) {
      const CandumpLines lines(deltas || LooksLikeDeltas(sample));
      return std::make_unique<TextLog<CandumpLines>>(lines);
    }
    if (HasAscHead(text) || Try(text, Asc()).frame) {
      return std::make_unique<TextLog<Asc>>(Asc());
    }
    const std::size_t feed = text.find('\n');
    text.remove_prefix(feed == std::string_view::npos ? text.size() : feed + 1);
  }
  return nullptr;
}

}  // namespace pipewright::hil
