// SPDX-License-Identifier: MIT
#include "hil/cli/replay_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include "hil/cli/canlog_input.h"
#include "hil/cli/replay_figures.h"
#include "hil/cli/replay_run.h"
#include "hil/replay/depth_recording.h"

namespace pipewright::hil {
namespace {

namespace fs = std::filesystem;

constexpr int kOk = 0;
constexpr int kFailed = 1;

struct ReplayOptions {
  std::string log;
  std::string run;
  std::string depth;
  std::string speed = "max";
  bool compare = false;
  bool json = false;
};

void Warn(const std::string& what) { fmt::print(stderr, "pipewright: warning: {}\n", what); }

/// The run's files: those named, else those beside the log.
ReplayFiles FilesOf(const ReplayOptions& options) {
  ReplayFiles files{options.log, options.run, options.depth};
  std::error_code failed;
  if (fs::is_directory(options.log, failed)) {
    files.log = fs::path(options.log) / "can.log";
  }
  const fs::path beside = files.log == "-" ? fs::path() : fs::path(files.log).parent_path();
  if (files.run.empty()) {
    files.run = beside / "run.json";
  }
  if (files.depth.empty() && fs::exists(beside / kDepthFileName, failed)) {
    files.depth = beside / kDepthFileName;
  }
  return files;
}

RecordedProgramResult LoadProgram(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return {std::nullopt, fmt::format("{}: cannot be read; it says how the robot program was set "
                                      "up. --run names another place",
                                      path)};
  }
  std::ostringstream text;
  text << file.rdbuf();
  try {
    RecordedProgramResult result = ReadProgram(nlohmann::ordered_json::parse(text.str()));
    if (!result.error.empty()) {
      result.error = fmt::format("{}: {}", path, result.error);
    }
    return result;
  } catch (const nlohmann::ordered_json::parse_error& wrong) {
    return {std::nullopt, fmt::format("{}: byte {}: is no JSON", path, wrong.byte)};
  } catch (const nlohmann::ordered_json::out_of_range& wrong) {
    return {std::nullopt, fmt::format("{}: holds a number beyond any: {}", path, wrong.what())};
  }
}

void ShowProgress(const ReplayProgress& p, bool terminal, bool compare) {
  const std::string line =
      fmt::format("{:6.0f} s  {:<11}  seen {:5.1f} %{}", ToSeconds(p.now), Name(p.state),
                  100.0 * (p.counts.free + p.counts.occupied) / std::max(1, p.counts.total),
                  compare ? fmt::format("  commands that differ {}", p.differences) : "");
  if (terminal) {
    fmt::print(stderr, "\r\033[K{}", line);
    std::fflush(stderr);
  } else if (static_cast<long>(ToSeconds(p.now)) % 30 == 0) {
    fmt::print(stderr, "{}\n", line);
  }
}

/// Says what of the recording could not be used. @returns the exit code for that
int TellDamage(const ReplayFiles& files, const RecordedBus& bus, const DepthReader* depth,
               double replayed_s) {
  int exit_code = TellProblems(bus.log());
  const auto tell = [&exit_code](const std::string& path, const std::string& what) {
    fmt::print(stderr, "pipewright: {}: {}\n", path, what);
    exit_code = std::max(exit_code, kFailed);
  };
  if (bus.passed_over() > 0) {
    tell(files.log, fmt::format("{} frames were passed over: CAN FD, or without a time, or a time "
                                "before those of the frames about them",
                                bus.passed_over()));
  }
  if (bus.beyond_silence() > 0) {
    tell(files.log, fmt::format("{} frames behind a silence of more than {} s were passed over",
                                bus.beyond_silence(), ToSeconds(bus.kLongestSilence)));
  }
  if (depth != nullptr && !depth->end().empty()) {
    tell(files.depth, depth->end());
  }
  if (exit_code != kOk) {
    fmt::print(stderr, "pipewright: replayed what is whole, up to {:.3f} s\n", replayed_s);
  }
  return exit_code;
}

int Replay(const ReplayOptions& options) {
  const ReplayFiles files = FilesOf(options);
  RecordedProgramResult loaded = LoadProgram(files.run);
  if (!loaded.program) {
    return Refuse(loaded.error);
  }
  RecordedBus bus(files.log);
  if (const std::string error = bus.Open(); !error.empty()) {
    return Refuse(error);
  }
  DepthReader depth;
  const bool sees = !files.depth.empty();
  if (const std::string error = sees ? depth.Open(files.depth) : ""; !error.empty()) {
    return Refuse(error);
  }
  if (!sees) {
    Warn(fmt::format(
        "there is no {} beside the log: the program runs WITHOUT DEPTH, sees nothing, and gives\n"
        "its camera up for lost. Commands can be the same only until a frame mattered. "
        "`inspect --record-depth` records them",
        kDepthFileName));
  }
  const bool terminal = isatty(STDERR_FILENO) == 1;
  nlohmann::ordered_json program = RunReplay(
      {.program = *loaded.program,
       .bus = bus,
       .depth = sees ? &depth : nullptr,
       .speed = options.speed == "max" ? 0 : std::stod(options.speed),
       .progress = [&](const ReplayProgress& p) { ShowProgress(p, terminal, options.compare); }});
  if (terminal) {
    fmt::print(stderr, "\r\033[K");
  }
  bus.ReadToEnd();
  const int damage =
      TellDamage(files, bus, sees ? &depth : nullptr, program["replayed_s"].get<double>());
  const nlohmann::ordered_json json =
      ReplayJson(files, bus, sees ? &depth : nullptr, std::move(program), options.compare);
  const int printed = Print(options.json ? Dump(json) : ReplayTable(json));
  const bool differs = options.compare && bus.comparison().differences() > 0;
  return std::max({damage, printed, differs ? kFailed : kOk});
}

/// `max`, or a number above 0.
std::string SpeedError(std::string& text) {
  double speed = 0;
  const bool good =
      text == "max" || (CLI::detail::lexical_cast(text, speed) && speed >= 0.01 && speed <= 1e4);
  return good ? "" : fmt::format("{} is neither max nor a number from 0.01 to 10000", text);
}

}  // namespace

void AddReplay(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "replay", "Run the robot program on a recorded run, and compare what it commands");
  const auto options = std::make_shared<ReplayOptions>();
  command
      ->add_option("LOG", options->log,
                   "a run's folder or its can.log, or another CAN log of base and arm in any\n"
                   "format that `canlog` reads; - is standard input")
      ->required();
  command
      ->add_option("--speed", options->speed,
                   "times the wall clock's, 1 for the time that it took; max: as fast as it goes")
      ->check(CLI::Validator(SpeedError, "max or X"))
      ->capture_default_str();
  command->add_flag("--compare", options->compare,
                    "hold every command against the one that was recorded: the first difference\n"
                    "in words, and how many of each id differ");
  command->add_option("--run", options->run,
                      "the run.json that says how the program was set up (default: beside LOG)");
  command->add_option("--depth", options->depth,
                      fmt::format("the depth frames (default: {} beside LOG)", kDepthFileName));
  command->add_flag("--json", options->json, "print one object, and nothing else, on stdout");
  command->callback([options, exit_code] { *exit_code = Replay(*options); });
  command->footer(
      "What the devices sent reaches the program at the times of the log, and depth frames when\n"
      "they did then, all in virtual time. A run of `inspect --record-depth` in virtual time\n"
      "replays byte for byte. One in real time (--bus can0) does not: when its threads ran is not\n"
      "recorded; nor does one without depth frames. A log or recording that breaks off or is\n"
      "damaged is replayed as far as all is whole.\n"
      "Exit code: 0 done; 1 with --compare: a command differs; or a part of the recording makes\n"
      "no sense, or it breaks off; 2 the input is bad.\n"
      "Examples: pipewright inspect --scenario pipes1 --record-depth --out run\n"
      "          pipewright replay run --compare");
}

}  // namespace pipewright::hil
