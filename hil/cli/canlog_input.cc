// SPDX-License-Identifier: MIT
#include "hil/cli/canlog_input.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>

#include "hil/canlog/frame_rows.h"

namespace pipewright::hil {
namespace {

constexpr int kBarCells = 40;
constexpr std::chrono::milliseconds kBarPeriod{100};

/// A bar on standard error, drawn anew ten times a second and wiped at the end.
class ProgressBar {
 public:
  void Show(std::uint64_t bytes, std::uint64_t in_all) {
    const auto now = std::chrono::steady_clock::now();
    if (in_all == 0 || (now - shown_ < kBarPeriod && bytes < in_all)) {
      return;
    }
    if (bytes >= in_all) {
      fmt::print(stderr, "{}", drawn_ ? "\r\033[K" : "");
    } else {
      const double done = static_cast<double>(bytes) / static_cast<double>(in_all);
      const auto cells = static_cast<std::size_t>(done * kBarCells);
      fmt::print(stderr, "\r\033[K[{:<{}}] {:3.0f} %  {} of {} MB", std::string(cells, '='),
                 kBarCells, 100 * done, bytes / 1'000'000, in_all / 1'000'000);
    }
    std::fflush(stderr);
    drawn_ = bytes < in_all;
    shown_ = now;
  }

 private:
  bool drawn_ = false;
  std::chrono::steady_clock::time_point shown_ = std::chrono::steady_clock::now();
};

/// Ctrl-C goes to the whole pipe: it ends the program that sends the log, and what came is still to
/// be told. A second one ends this program, too.
void LetTheSenderEnd(int) { std::signal(SIGINT, SIG_DFL); }

}  // namespace

std::string CanlogInput::Open(const CanlogOptions& options) {
  FrameFilter filter;
  std::string error;
  for (const std::string& ids : options.ids) {
    error = error.empty() ? filter.AddIds(ids) : error;
  }
  if (error.empty() && !options.from.empty()) {
    error = filter.SetFrom(options.from);
  }
  if (error.empty() && !options.to.empty()) {
    error = filter.SetTo(options.to);
  }
  if (std::find(options.files.begin(), options.files.end(), "-") != options.files.end()) {
    std::signal(SIGINT, LetTheSenderEnd);
  }
  log_ = std::make_unique<LogSet>(options.files, LogOptions{.deltas = options.deltas}, filter);
  if (isatty(STDERR_FILENO) == 1) {
    log_->set_progress([bar = ProgressBar()](std::uint64_t bytes, std::uint64_t in_all) mutable {
      bar.Show(bytes, in_all);
    });
  }
  return error;
}

int TellProblems(const LogSet& log) {
  if (!log.error().empty()) {
    return Refuse(log.error());
  }
  for (const FileRead& file : log.files()) {
    const LogProblems& problems = file.problems;
    for (const std::string& told : problems.told()) {
      fmt::print(stderr, "pipewright: {}: {}\n", file.path, told);
    }
    if (problems.malformed() > problems.told().size()) {
      fmt::print(stderr, "pipewright: {}: {} records in all make no sense and were passed over\n",
                 file.path, problems.malformed());
    }
    if (!problems.end().empty()) {
      fmt::print(stderr, "pipewright: {}: {}\n", file.path, problems.end());
    }
  }
  return log.whole() ? kCanlogOk : kCanlogFailed;
}

nlohmann::ordered_json FilesJson(const LogSet& log) {
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  for (const FileRead& file : log.files()) {
    const std::string& end = file.problems.end();
    files.push_back({{"path", file.path},
                     {"format", file.format},
                     {"packing", file.packing},
                     {"bytes", file.bytes},
                     {"frames", file.frames},
                     {"malformed", file.problems.malformed()},
                     {"first_malformed", file.problems.told()},
                     {"ends_early", end.empty() ? nlohmann::ordered_json(nullptr)
                                                : nlohmann::ordered_json(end)}});
  }
  return files;
}

std::string FilesJsonText(const LogSet& log) {
  return FilesJson(log).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string FilesText(const LogSet& log) {
  std::string text;
  for (const FileRead& file : log.files()) {
    text +=
        fmt::format("{}: {}{}, {} frames, {} bytes\n", file.path, file.format,
                    file.packing == "none" ? "" : " in " + file.packing, file.frames, file.bytes);
  }
  return text;
}

int Refuse(const std::string& why) {
  fmt::print(stderr, "pipewright: {}\n", why);
  return kCanlogBadInput;
}

int OutputFailed() {
  fmt::print(stderr, "pipewright: standard output took no more\n");
  return kCanlogFailed;
}

int Print(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) < text.size() || std::fflush(stdout) != 0) {
    return OutputFailed();
  }
  return kCanlogOk;
}

std::string Dump(const nlohmann::ordered_json& object) {
  return object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string IdText(const IdKey& id) {
  return id.error      ? fmt::format("error {:X}", id.id)
         : id.extended ? fmt::format("{:08X}", id.id)
                       : fmt::format("{:03X}", id.id);
}

std::string FrameName(const IdKey& id) {
  const int row = RowOf(id.id, id.extended, id.error);
  if (row < 0) {
    return "";
  }
  const can::FrameHead& head = kLogHeads[static_cast<std::size_t>(row)];
  const int node = can::NodeOf(head, id.id);
  return node > 0 ? fmt::format("{} {}", head.name, node) : std::string(head.name);
}

std::string PayloadText(const LogFrame& frame) {
  std::string text = frame.remote ? fmt::format("remote {}", frame.length) : "";
  for (int i = 0; i < frame.payload_bytes(); ++i) {
    text += fmt::format("{:02X}", frame.data[static_cast<std::size_t>(i)]);
  }
  return text;
}

std::string StampText(std::int64_t ns) {
  const std::int64_t seconds = ns / 1'000'000'000;
  const std::int64_t rest = ns % 1'000'000'000;
  return rest % 1000 == 0 ? fmt::format("{}.{:06}", seconds, rest / 1000)
                          : fmt::format("{}.{:09}", seconds, rest);
}

}  // namespace pipewright::hil
