// SPDX-License-Identifier: MIT
// How fast logs are read: one log of the robot's bus in every format, its statistics by
// `pipewright canlog`, and the same file by log2asc and python-can where they are installed. Whole
// programs, by the clock, in turn; the least of all passes.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "hil/canlog/frame_rows.h"
#include "tests/bench/stopwatch.h"
#include "tests/support/can_logs.h"

namespace pipewright::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kPcapHeadBytes = 24;
constexpr int kCycle_ms = 10;

struct Options {
  int frames = 1'000'000;
  int passes = 3;
  std::uint64_t seed = 1;
  bool json = false;
};

/// A program that reads a file.
struct Reader {
  std::string what;
  std::string file;
  std::string command;
  Stopwatch watch;
  bool worked = true;
};

/// Every periodic frame of base and arm, with payloads of noise, cycle by cycle.
class Bus {
 public:
  explicit Bus(std::uint64_t seed) : rng_(seed) {}

  std::vector<hil::LogFrame> Next(int count) {
    std::vector<hil::LogFrame> frames;
    for (; static_cast<int>(frames.size()) < count; ++cycle_) {
      for (const can::FrameHead& head : hil::kLogHeads) {
        const int period = static_cast<int>(head.period / std::chrono::milliseconds(kCycle_ms));
        const int nodes = std::min(head.max_node, can::kArmNodes);
        for (int node = nodes > 0 ? 1 : 0; period > 0 && cycle_ % period == 0 && node <= nodes;
             ++node) {
          frames.push_back(Frame(head, node));
        }
      }
    }
    frames.resize(static_cast<std::size_t>(count));
    return frames;
  }

 private:
  hil::LogFrame Frame(const can::FrameHead& head, int node) {
    std::vector<int> payload(static_cast<std::size_t>(head.dlc));
    for (int& byte : payload) {
      byte = rng_.Index(256);
    }
    stamp_ns_ =
        std::max(stamp_ns_ + 120'000, kBegin_ns + std::int64_t{kCycle_ms} * 1'000'000 * cycle_);
    return test::DataFrame(head.id + static_cast<std::uint32_t>(node), payload, stamp_ns_);
  }

  static constexpr std::int64_t kBegin_ns = 1'699'000'000'000'000'000;
  Rng rng_;
  int cycle_ = 0;
  std::int64_t stamp_ns_ = kBegin_ns;
};

void WriteLogs(const Options& options, const fs::path& folder) {
  std::ofstream text(folder / "a.log", std::ios::binary);
  std::ofstream candump(folder / "a.txt", std::ios::binary);
  std::ofstream asc(folder / "a.asc", std::ios::binary);
  std::ofstream pcap(folder / "a.pcap", std::ios::binary);
  Bus bus(options.seed);
  pcap << test::Pcap({}, /*big=*/false, /*ns=*/true);
  for (int left = options.frames; left > 0;) {
    const int count = std::min(left, 50'000);
    const std::vector<hil::LogFrame> frames = bus.Next(count);
    text << test::CandumpLog(frames);
    candump << test::CandumpText(frames);
    asc << test::AscText(frames);  // a head more now and then does no harm
    pcap << test::Pcap(frames, false, true).substr(kPcapHeadBytes);
    left -= count;
  }
}

bool Runs(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1").c_str()) == 0;
}

std::vector<Reader> Readers(const fs::path& folder) {
  const std::string program = (fs::read_symlink("/proc/self/exe").parent_path() / "pipewright");
  const auto in = [&folder](const char* name) { return (folder / name).string(); };
  std::vector<Reader> readers;
  const auto ours = [&](const char* what, const char* name, const char* options) {
    readers.push_back(
        {what, in(name), fmt::format("'{}' canlog {} '{}'", program, options, in(name)), {}, true});
  };
  ours("stats, candump -L", "a.log", "stats");
  ours("stats with load, candump -L", "a.log", "stats --bitrate 500000");
  ours("stats, candump -t a", "a.txt", "stats");
  ours("stats, ASC", "a.asc", "stats");
  ours("stats, pcap", "a.pcap", "stats");
  if (Runs("gzip -k '" + in("a.log") + "'")) {
    ours("stats, candump -L in gz", "a.log.gz", "stats");
  }
  if (Runs("zstd -q '" + in("a.log") + "'")) {
    ours("stats, candump -L in zstd", "a.log.zst", "stats");
  }
  ours("gaps, candump -L", "a.log", "gaps --most 1");
  ours("decode, candump -L", "a.log", "decode");
  if (Runs("command -v log2asc")) {
    readers.push_back({"log2asc",
                       in("a.log"),
                       fmt::format("log2asc -I '{}' -O /dev/null can0", in("a.log")),
                       {},
                       true});
  }
  if (Runs("/usr/bin/python3 -c 'import can'")) {
    readers.push_back(
        {"python-can",
         in("a.log"),
         fmt::format("/usr/bin/python3 -c 'import can; n = sum(1 for _ in can.LogReader(\"{}\"))'",
                     in("a.log")),
         {},
         true});
  }
  return readers;
}

int Measure(const Options& options, const fs::path& folder) {
  WriteLogs(options, folder);
  std::vector<Reader> readers = Readers(folder);
  for (int pass = 0; pass < options.passes; ++pass) {
    for (Reader& reader : readers) {
      // `gaps` finds the noise in the counts, and says so by its exit code.
      const bool may_fail = reader.what.starts_with("gaps");
      reader.watch.Time(0, [&] { reader.worked = Runs(reader.command) || may_fail; });
    }
  }
  Json all = Json::array();
  bool worked = true;
  if (!options.json) {
    fmt::print("{} frames, least of {} passes\n{:<28} {:>8} {:>8} {:>12} {:>8}\n", options.frames,
               options.passes, "", "MB", "s", "frames/s", "MB/s");
  }
  for (const Reader& reader : readers) {
    const double s = reader.watch.least_s();
    const double mb = 1e-6 * static_cast<double>(fs::file_size(reader.file));
    worked = worked && reader.worked;
    all.push_back({{"what", reader.what},
                   {"MB", mb},
                   {"s", s},
                   {"frames_per_s", options.frames / s},
                   {"worked", reader.worked}});
    if (!options.json) {
      fmt::print("{:<28} {:>8.1f} {:>8.3f} {:>12.3e} {:>8.1f}{}\n", reader.what, mb, s,
                 options.frames / s, mb / s, reader.worked ? "" : "  FAILED");
    }
  }
  if (options.json) {
    fmt::print(
        "{}\n",
        Json{{"frames", options.frames}, {"passes", options.passes}, {"readers", all}}.dump(2));
  }
  return worked ? 0 : 1;
}

int Run(const Options& options) {
  std::string folder = (fs::temp_directory_path() / "pipewright_canlog_XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) {
    fmt::print(stderr, "bench_canlog: cannot make the folder {}\n", folder);
    return 2;
  }
  const int result = Measure(options, folder);
  std::error_code error;
  fs::remove_all(folder, error);
  return result;
}

}  // namespace
}  // namespace pipewright::bench

int main(int argc, char** argv) {
  pipewright::bench::Options options;
  CLI::App app("How fast CAN logs are read, beside log2asc and python-can", "bench_canlog");
  app.add_option("--frames", options.frames, "length of the log")
      ->check(CLI::Range(1000, 100'000'000))
      ->capture_default_str();
  app.add_option("--passes", options.passes)->check(CLI::Range(1, 1000))->capture_default_str();
  app.add_option("--seed", options.seed)->capture_default_str();
  app.add_flag("--json", options.json, "print one object, and nothing else, on stdout");
  CLI11_PARSE(app, argc, argv);
  return pipewright::bench::Run(options);
}
