// SPDX-License-Identifier: MIT
#include "hil/canlog/log_reader.h"

#include <fmt/format.h>

#include "hil/canlog/pcap_packets.h"
#include "hil/canlog/pcapng_blocks.h"
#include "hil/canlog/text_log.h"

namespace pipewright::hil {
namespace {

constexpr std::size_t kBlockFrames = 256;
constexpr std::size_t kLongestMagic = 4;
constexpr std::size_t kSampleBytes = 64 * 1024;

std::unique_ptr<LogFormat> FormatOf(std::string_view begin, const LogOptions& options) {
  if (PcapngBlocks::Begins(begin)) {
    return std::make_unique<PcapngBlocks>();
  }
  if (PcapPackets::Begins(begin)) {
    return std::make_unique<PcapPackets>();
  }
  return TextFormatOf(begin, options.deltas);
}

}  // namespace

LogReader::LogReader(ChannelNames& channels) : channels_(channels), block_(kBlockFrames) {}

std::string LogReader::Open(const std::string& path, const LogOptions& options) {
  const std::string error = source_.Open(path);
  return error.empty() ? Begin(path, options) : fmt::format("{}: {}", path, error);
}

std::string LogReader::Open(std::FILE* file, const std::string& name, const LogOptions& options) {
  source_.Open(file);
  return Begin(name, options);
}

std::string LogReader::Begin(const std::string& name, const LogOptions& options) {
  const std::string_view begin = window_.Peek(kSampleBytes);
  format_ = FormatOf(begin, options);
  whole_lines_ = options.whole_lines;
  if (format_ || begin.empty()) {
    return "";
  }
  const bool one_line = begin.find_first_of(std::string_view("\n\0", 2)) == begin.npos &&
                        begin.size() < ByteWindow::kMostLine;
  if (begin.size() < kLongestMagic || one_line) {
    problems_.EndsEarly("ends within its first line or head");
    return "";
  }
  return fmt::format(
      "{}: is no log that is known here: no line of its first is one of candump -L, such as "
      "'(1699000000.123456) can0 123#DEADBEEF', of candump or of ASC, nor does it begin as pcap or "
      "pcapng",
      name);
}

std::span<LogFrame> LogReader::Next() {
  LogInput in{window_, channels_, problems_, whole_lines_};
  const std::size_t frames = format_ ? format_->Fill(in, block_) : 0;
  if (frames < block_.size() && !source_.error().empty()) {
    problems_.EndsEarly(source_.error());
  }
  return {block_.data(), frames};
}

}  // namespace pipewright::hil
