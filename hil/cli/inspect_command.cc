// SPDX-License-Identifier: MIT
#include "hil/cli/inspect_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include "hil/cli/bus_choice.h"
#include "hil/cli/can_interfaces.h"
#include "hil/cli/in_range.h"
#include "hil/cli/inspection.h"
#include "hil/cli/interrupts.h"
#include "hil/cli/program_record.h"
#include "hil/cli/realtime_run.h"
#include "hil/cli/scenario_choice.h"
#include "hil/cli/virtual_run.h"
#include "platform/linux/clock.h"

namespace pipewright::hil {
namespace {

constexpr int kOk = 0;
constexpr int kFailed = 1;
constexpr int kBadInput = 2;

std::filesystem::path FolderOf(const Scenario& scenario, const InspectionOptions& options) {
  if (!options.out.empty()) {
    return options.out;
  }
  const std::string faults = options.faults ? "-" + NameOfConditions(*options.faults) : "";
  return std::filesystem::path("runs") /
         fmt::format("{}{}-{}-{}", scenario.name, faults, Name(options.planner), options.seed);
}

nlohmann::ordered_json Head(const Scenario& scenario, const InspectionOptions& options) {
  return {{"scenario", scenario.name},
          {"faults", FaultsJson(options)},
          {"seed", options.seed},
          {"planner", Name(options.planner)},
          {"program", ProgramJson(scenario, options)},
          {"stop_reason", "running"}};
}

void ShowProgress(const RunProgress& p, bool terminal) {
  const std::string truth = p.truth ? fmt::format("  covered {:5.1f} %  contacts {}",
                                                  100 * p.truth->coverage_ratio, p.truth->contacts)
                                    : "";
  const std::string line =
      fmt::format("{:6.0f} s  {:<11}  seen {:5.1f} %{}", ToSeconds(p.now), Name(p.state),
                  100.0 * (p.counts.free + p.counts.occupied) / std::max(1, p.counts.total), truth);
  if (terminal) {
    fmt::print(stderr, "\r\033[K{}", line);
    std::fflush(stderr);
  } else if (static_cast<long>(ToSeconds(p.now)) % 30 == 0) {
    fmt::print(stderr, "{}\n", line);
  }
}

/// Opens the wires that --bus names, if they are the kernel's. @returns an error in words, or
/// nothing
std::string OpenBus(const InspectionOptions& options, const BusChoice& bus,
                    CanInterfaces* interfaces) {
  if (std::string error = RateError(options.rate_hz, bus.shared); !error.empty()) {
    return error;
  }
  if (!bus.is_virtual()) {
    return interfaces->Open(bus.interfaces, !options.no_devices);
  }
  return options.no_devices ? "--no-devices: a loopback bus has none but the emulated ones" : "";
}

/// @returns an error in words, or nothing
std::string CheckCamera(DepthSocket& camera) {
  const auto frame = std::make_unique<DepthFrame>();
  return camera.Poll(Now(), *frame) == Status::kUnavailable
             ? fmt::format("--camera {}", camera.error_text())
             : "";
}

RunHooks Hooks(bool terminal) {
  CatchInterrupts();
  RunHooks hooks;
  hooks.progress = [terminal](const RunProgress& p) { ShowProgress(p, terminal); };
  hooks.interrupted = Interrupted;
  return hooks;
}

int Report(const InspectionOptions& options, const nlohmann::ordered_json& run, RunFolder& folder) {
  folder.Text("run.json", run.dump(2) + "\n");
  if (const std::string error = folder.Close(); !error.empty()) {
    fmt::print(stderr, "pipewright: {}\n", error);
    return kFailed;
  }
  if (options.json) {
    fmt::print("{}\n", run.dump(2));
  } else {
    fmt::print("{}", RunTable(run, folder.path().string()));
  }
  return Passed(run) ? kOk : kFailed;
}

int Inspect(const InspectionOptions& options) {
  const std::optional<Scenario> loaded = LoadToRun(options.scenario, options.faults);
  if (!loaded) {
    return kBadInput;
  }
  const Scenario& scenario = *loaded;
  std::string error;
  const BusChoice bus = ParseBus(options.bus, &error);
  CanInterfaces interfaces;
  const auto camera = std::make_unique<DepthSocket>(options.camera);
  RunFolder folder;
  if (error.empty()) {
    error = OpenBus(options, bus, &interfaces);
  }
  if (error.empty() && !options.camera.empty()) {
    error = CheckCamera(*camera);
  }
  if (error.empty()) {
    error = folder.Open(FolderOf(scenario, options), Head(scenario, options), options.record_depth);
  }
  if (!error.empty()) {
    fmt::print(stderr, "pipewright: {}\n", error);
    return kBadInput;
  }
  const bool terminal = isatty(STDERR_FILENO) == 1;
  const RunHooks hooks = Hooks(terminal);
  RealtimePorts ports = bus.is_virtual() ? RealtimePorts{} : interfaces.Ports();
  ports.camera = options.camera.empty() ? nullptr : camera.get();
  const nlohmann::ordered_json run = bus.is_virtual()
                                         ? RunVirtual(scenario, options, folder, hooks)
                                         : RunRealtime(ports, scenario, options, folder, hooks);
  if (terminal) {
    fmt::print(stderr, "\r\033[K");
  }
  return Report(options, run, folder);
}

std::map<std::string, SvfiMode> SvfiModesByName() {
  std::map<std::string, SvfiMode> modes;
  for (const SvfiMode mode : kSvfiModes) {
    modes[Name(mode)] = mode;
  }
  return modes;
}

}  // namespace

void AddInspect(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "inspect", "Run one inspection mission against emulated devices, and leave its evidence");
  const auto options = std::make_shared<InspectionOptions>();
  command
      ->add_option("--scenario", options->scenario,
                   "pipes1, pipes2, pipes3, or a TOML file of your own "
                   "(start from hil/world/scenarios/pipes3.toml)")
      ->capture_default_str();
  CLI::Option* faults = command->add_option(
      "--faults", options->faults,
      "laid over the scenario: rough (a noisy camera, lost frames, wheels that slip), or a\n"
      "TOML file of your own (start from hil/world/conditions/rough.toml)");
  command->add_option("--seed", options->seed, "of sensor noise and planning")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command
      ->add_option("--planner", options->planner,
                   "cfnbv: reachable views, motion cost; cfnbv_paper: as published")
      ->transform(CLI::CheckedTransformer(std::map<std::string, PlannerKind>{
          {"cfnbv", PlannerKind::kCfnbv}, {"cfnbv_paper", PlannerKind::kCfnbvPaper}}))
      ->default_str("cfnbv");
  command->add_option("--svfi", options->svfi, "how chance constraints see the velocity to be sent")
      ->transform(CLI::CheckedTransformer(SvfiModesByName()))
      ->default_str(Name(options->svfi));
  command
      ->add_option("--alpha", options->alpha,
                   "probability that each uncertain constraint holds, in [0.5, 1)")
      ->check(InRange(0.5, 0.999999))
      ->capture_default_str();
  command->add_flag("--wheels-alone{false}", options->scans_correct,
                    "take the base's pose from the wheels alone, not corrected by scans");
  command->add_flag("--joint-risk", options->joint_risk,
                    "--alpha is of all constraints of a cycle together, not of each");
  command
      ->add_option("--rate", options->rate_hz,
                   "of the control task, Hz: a whole number of ms, at most 125 on one bus for all")
      ->check(InRange(50, 1000))
      ->capture_default_str();
  command->add_flag("--realtime", options->realtime, "keep pace with the wall clock");
  command
      ->add_option("--bus", options->bus,
                   "in virtual time: loopback (two buses) or loopback-shared (one);\n"
                   "in real time: a CAN interface for all (can0), or base,arm (can0,can1)")
      ->capture_default_str();
  CLI::Option* no_devices =
      command
          ->add_flag(
              "--no-devices", options->no_devices,
              "the devices are elsewhere on the interface (pipewright emulate): emulate none.\n"
              "Contacts and coverage are then known there alone, and null in run.json")
          ->excludes(faults);  // only what is emulated can be made to fail
  command
      ->add_option("--camera", options->camera,
                   "with --no-devices: the Unix socket at which depth frames come")
      ->needs(no_devices);
  command->add_option("--out", options->out,
                      "folder for the evidence (default: runs/SCENARIO[-FAULTS]-PLANNER-SEED)");
  command->add_flag("--record-depth", options->record_depth,
                    "the depth frames too, so that `pipewright replay` can show the program all\n"
                    "that it saw; some 0.25 MB a second");
  command->add_option("--time-limit", options->time_limit_s, "of simulated time, s")
      ->check(InRange(1, 1e5))
      ->capture_default_str();
  command->add_flag("--json", options->json,
                    "print run.json's object, and nothing else, on stdout");
  command->callback([options, exit_code] { *exit_code = Inspect(*options); });
  command->footer(
      "Exit code: 0 the mission is complete and, as far as is known here, nothing was touched;\n"
      "1 it ended otherwise; 2 the input is bad.\n"
      "Example: pipewright inspect --scenario pipes2 --seed 7 --out /tmp/run");
}

}  // namespace pipewright::hil
