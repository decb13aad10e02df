// SPDX-License-Identifier: MIT
// Mission after mission in one process, in virtual time, for an hour of the robot's: whether
// anything grows. A robot program takes all its memory at start, so a leak is the devices', the
// recording's or the page's; a latency that grows is anybody's.
#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "hil/cli/interrupts.h"
#include "hil/cli/scenario_choice.h"
#include "hil/cli/virtual_run.h"

namespace pipewright::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kBadInput = 2;  ///< exit code

constexpr double kHeapGrowth_bytes = 256;       ///< a mission
constexpr double kResidentGrowth_bytes = 16e6;  ///< from the first half to the second
constexpr double kSlower = 1.25;                ///< the same; the machine's own noise is in it

struct Options {
  std::vector<std::string> scenarios = {"pipes1", "pipes2", "pipes3"};
  std::optional<std::string> faults;
  std::uint64_t seed = 1;
  double minutes = 60;
  bool json = false;
};

struct Run {
  std::string scenario;
  std::uint64_t seed = 0;
  std::string stop;
  double time_s = 0;  ///< the robot's
  double heap_bytes = 0;
  double resident_bytes = 0;
  double cycle_p50_us = 0;
  std::uint64_t allocations = 0;  ///< within control cycles
  std::uint64_t dropped = 0;      ///< CAN frames
  int contacts = 0;
};

Json ToJson(const Run& run) {
  return {{"scenario", run.scenario},         {"seed", run.seed},
          {"stop_reason", run.stop},          {"time_s", run.time_s},
          {"heap_bytes", run.heap_bytes},     {"resident_bytes", run.resident_bytes},
          {"cycle_p50_us", run.cycle_p50_us}, {"heap_allocations", run.allocations},
          {"frames_dropped", run.dropped},    {"contacts", run.contacts}};
}

double ResidentBytes() {
  std::ifstream statm("/proc/self/statm");
  double pages = 0;
  double resident = 0;
  statm >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// Of all arenas, and of what is mapped by itself.
double HeapBytes() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

/// glibc counts what a thread has freed and keeps for itself as in use, some 3 kB more after each
/// mission. Begins the program anew without such caches, unless its settings were given.
void CountWhatIsInUse(char** argv) {
  constexpr const char* kSettings = "GLIBC_TUNABLES";
  if (std::getenv(kSettings) == nullptr &&
      setenv(kSettings, "glibc.malloc.tcache_count=0", 1) == 0) {
    execv("/proc/self/exe", argv);  // if it fails, the growth shows
  }
}

Run OneMission(const hil::Scenario& scenario, const hil::InspectionOptions& options,
               const fs::path& folder) {
  Run run;
  run.scenario = scenario.name;
  run.seed = options.seed;
  {
    hil::RunFolder evidence;
    if (const std::string error = evidence.Open(folder, {}); !error.empty()) {
      throw std::runtime_error(error);
    }
    hil::RunHooks hooks;
    hooks.interrupted = hil::Interrupted;
    const Json json = RunVirtual(scenario, options, evidence, hooks);
    if (const std::string error = evidence.Close(); !error.empty()) {
      throw std::runtime_error(error);
    }
    run.stop = json["stop_reason"];
    run.time_s = json["sim_time_s"];
    run.cycle_p50_us = json["control"]["cycle_us"]["p50"];
    run.allocations = json["control"]["heap_allocations"];
    run.dropped = json["can"]["dropped"];
    run.contacts = json["contacts"];
  }
  run.heap_bytes = HeapBytes();
  run.resident_bytes = ResidentBytes();
  return run;
}

/// Of a straight line through all, by least squares.
double Slope(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double sum_x = 0;
  double sum_y = 0;
  double sum_xx = 0;
  double sum_xy = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto x = static_cast<double>(i);
    sum_x += x;
    sum_y += values[i];
    sum_xx += x * x;
    sum_xy += x * values[i];
  }
  const double spread = n * sum_xx - sum_x * sum_x;
  return spread > 0 ? (n * sum_xy - sum_x * sum_y) / spread : 0;
}

double Median(std::vector<double> values) {
  if (values.empty()) {
    return 0;
  }
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

struct Halves {
  double first = 0;
  double second = 0;
};

/// The median of each.
Halves HalvesOf(const std::vector<double>& values) {
  const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  return {Median({values.begin(), half}), Median({half, values.end()})};
}

/// What a scenario's first mission leaves for good (its coverable surfaces, for one) is no growth:
/// the first round is left out.
Json Summary(const std::vector<Run>& runs, std::size_t scenarios) {
  double time_s = 0;
  std::uint64_t allocations = 0;
  std::uint64_t dropped = 0;
  int contacts = 0;
  std::map<std::string, int> stops;
  std::vector<double> heap;
  std::vector<double> resident;
  std::map<std::string, std::vector<double>> cycles;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Run& run = runs[i];
    time_s += run.time_s;
    allocations += run.allocations;
    dropped += run.dropped;
    contacts += run.contacts;
    ++stops[run.stop];
    cycles[run.scenario].push_back(run.cycle_p50_us);
    if (i >= scenarios) {
      heap.push_back(run.heap_bytes);
      resident.push_back(run.resident_bytes);
    }
  }
  double slower = 0;  // the geometric mean over scenarios: no two take the same time
  for (const auto& [scenario, us] : cycles) {
    const Halves halves = HalvesOf(us);
    slower += halves.first > 0
                  ? std::log(halves.second / halves.first) / static_cast<double>(cycles.size())
                  : 0;
  }
  const Halves held = HalvesOf(resident);
  return {{"missions", runs.size()},
          {"time_s", time_s},
          {"stops", stops},
          {"contacts", contacts},
          {"heap_allocations", allocations},
          {"frames_dropped", dropped},
          {"heap_growth_bytes_a_mission", Slope(heap)},
          {"resident_growth_bytes", held.first > 0 ? held.second - held.first : 0},
          {"cycle_p50_second_half_over_first", std::exp(slower)}};
}

/// In words; nothing if all holds.
std::string Wrong(const Json& summary) {
  const auto above = [&](const char* key, double most) {
    return summary[key].get<double>() > most
               ? fmt::format("{} is {:.6g}, above {:.6g}\n", key, summary[key].get<double>(), most)
               : "";
  };
  return above("heap_growth_bytes_a_mission", kHeapGrowth_bytes) +
         above("resident_growth_bytes", kResidentGrowth_bytes) +
         above("cycle_p50_second_half_over_first", kSlower) + above("heap_allocations", 0) +
         above("frames_dropped", 0) + above("contacts", 0);
}

int RunAll(const Options& options) {
  std::vector<hil::Scenario> scenarios;
  for (const std::string& name : options.scenarios) {
    const std::optional<hil::Scenario> scenario = hil::LoadToRun(name, options.faults);
    if (!scenario) {
      return kBadInput;
    }
    scenarios.push_back(*scenario);
  }
  std::string folder = (fs::temp_directory_path() / "pipewright_soak_XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) {
    fmt::print(stderr, "bench_soak: cannot make a folder in {}\n",
               fs::temp_directory_path().string());
    return kBadInput;
  }
  hil::CatchInterrupts();
  std::FILE* const told = options.json ? stderr : stdout;
  fmt::print(told, "{:<10} {:>5}  {:<18} {:>8} {:>11} {:>11} {:>9} {:>7} {:>8}\n", "scenario",
             "seed", "stopped by", "robot s", "heap MB", "resident MB", "cycle us", "allocs",
             "dropped");
  std::vector<Run> runs;
  runs.reserve(4096);  // so that this list is no growth
  double left_s = 60 * options.minutes;
  for (std::size_t i = 0; left_s > 0 && !hil::Interrupted(); ++i) {
    const hil::Scenario& scenario = scenarios[i % scenarios.size()];
    hil::InspectionOptions inspection;
    inspection.scenario = options.scenarios[i % scenarios.size()];
    inspection.faults = options.faults;
    inspection.seed = options.seed + i / scenarios.size();
    const Run run = OneMission(scenario, inspection, folder);
    left_s -= std::max(run.time_s, 1.0);
    runs.push_back(run);
    fmt::print(told, "{:<10} {:>5}  {:<18} {:>8.1f} {:>11.3f} {:>11.3f} {:>9.1f} {:>7} {:>8}\n",
               run.scenario, run.seed, run.stop, run.time_s, run.heap_bytes / 1e6,
               run.resident_bytes / 1e6, run.cycle_p50_us, run.allocations, run.dropped);
    std::fflush(told);
  }
  std::error_code error;
  fs::remove_all(folder, error);
  const Json summary = Summary(runs, scenarios.size());
  if (options.json) {
    Json out{{"missions", Json::array()}, {"summary", summary}};
    for (const Run& run : runs) {
      out["missions"].push_back(ToJson(run));
    }
    fmt::print("{}\n", out.dump(2));
  } else {
    fmt::print("\n");
    for (const auto& [key, value] : summary.items()) {
      fmt::print("{:<34} {}\n", key, value.dump());
    }
  }
  const std::string wrong = Wrong(summary);
  fmt::print(stderr, "{}", wrong);
  return wrong.empty() ? 0 : 1;
}

}  // namespace
}  // namespace pipewright::bench

int main(int argc, char** argv) {
  pipewright::bench::CountWhatIsInUse(argv);
  pipewright::bench::Options options;
  CLI::App app("Mission after mission in one process: whether memory or latency grows",
               "bench_soak");
  app.add_option("--scenarios", options.scenarios, "names or files, with commas between; by turns")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--faults", options.faults,
                 "laid over each scenario: a name or a file, as pipewright inspect takes them");
  app.add_option("--seed", options.seed, "of the first round; each has the next one")
      ->capture_default_str();
  app.add_option("--minutes", options.minutes, "of the robot's time, in all")
      ->check(CLI::Range(0.1, 1e5))
      ->capture_default_str();
  app.add_flag("--json", options.json, "one JSON object on stdout");
  app.footer(
      "Exit code: 0 nothing grows; 1 something does, and it is said what; 2 the input is bad.\n"
      "Ctrl-C ends it after the mission that runs.");
  try {
    app.parse(argc, argv);
    return pipewright::bench::RunAll(options);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const std::exception& e) {
    fmt::print(stderr, "bench_soak: {}\n", e.what());
    return 1;
  }
}
