// SPDX-License-Identifier: MIT
#include "hil/cli/emulate_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <deque>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "hil/cli/bus_load.h"
#include "hil/cli/emulate_run.h"
#include "hil/cli/in_range.h"
#include "hil/cli/interrupts.h"
#include "hil/cli/scenario_choice.h"
#include "platform/can/cia402.h"
#include "platform/can/tracer.h"

namespace pipewright::hil {
namespace {

constexpr int kOk = 0;
constexpr int kFailed = 1;
constexpr int kBadInput = 2;

/// What the command line gives in another shape than EmulationOptions.
struct RawOptions {
  std::string modes = "sdk";
  std::vector<double> ramp;
  std::vector<double> brake;
  std::vector<double> stop;
  std::vector<double> yaw_scale;
};

const std::map<std::string, can::ControlModeCodes>& ModesByName() {
  static const std::map<std::string, can::ControlModeCodes> kModes = {
      {"sdk", can::kModesSdk},
      {"tracer12", can::kModesTracer12},
      {"tracer20", can::kModesTracer20},
      {"mini", can::kModesMini}};
  return kModes;
}

/// A ramp as --ramp and its like give it: m/s^2 and rad/s^2.
void Take(const std::vector<double>& pair, double& linear, double& angular) {
  if (pair.size() == 2) {
    linear = pair[0];
    angular = pair[1];
  }
}

void TakeRaw(const RawOptions& raw, TracerConfig& tracer) {
  tracer.modes = ModesByName().at(raw.modes);
  Take(raw.ramp, tracer.accel_mps2, tracer.alpha_radps2);
  Take(raw.brake, tracer.brake_mps2, tracer.brake_radps2);
  Take(raw.stop, tracer.stop_mps2, tracer.stop_radps2);
}

void ShowProgress(const EmulationProgress& p) {
  fmt::print(stderr,
             "\r\033[K{:6.0f} s  base {:<7}  {} joints enabled  at {:.2f} m {:.2f} m {:.0f} deg  "
             "contacts {}",
             ToSeconds(p.now), p.base_in_can_mode ? "driven" : "standby", p.joints_enabled, p.x_m,
             p.y_m, p.yaw_rad * 180 / std::numbers::pi, p.contacts);
  std::fflush(stderr);
}

/// @returns an error in words, or nothing
std::string Open(const EmulationOptions& options, std::deque<WirePort>& wires,
                 DepthSender& camera) {
  const bool shared = options.arm_bus.empty() || options.arm_bus == options.bus;
  if (std::string error = LoadError(options.rate_hz, shared); !error.empty()) {
    return error;
  }
  std::string error = wires.emplace_back(options.bus, can::kTracerBitrate).Open("--bus");
  if (error.empty() && !shared) {
    error = wires.emplace_back(options.arm_bus, can::kArmBitrate).Open("--arm-bus");
  }
  if (error.empty() && !options.camera.empty()) {
    error = camera.Open(options.camera);
    error = error.empty() ? "" : "--camera " + error;
  }
  return error;
}

int Emulate(const EmulationOptions& options, const RawOptions& raw) {
  CatchInterrupts();  // from here on, a path that was made is also removed
  std::optional<Scenario> scenario = LoadToRun(options.scenario, options.faults);
  if (!scenario) {
    return kBadInput;
  }
  if (!raw.yaw_scale.empty()) {
    scenario->base.yaw_scale_slow = raw.yaw_scale.front();
    scenario->base.yaw_scale_fast = raw.yaw_scale.back();
  }
  std::deque<WirePort> wires;
  DepthSender camera;
  if (const std::string error = Open(options, wires, camera); !error.empty()) {
    fmt::print(stderr, "pipewright: {}\n", error);
    return kBadInput;
  }
  const bool terminal = isatty(STDERR_FILENO) == 1;
  EmulationHooks hooks;
  hooks.started = [&] {
    fmt::print(stderr, "pipewright: emulating on {}{}{}; Ctrl-C ends it\n", options.bus,
               wires.size() > 1 ? " and " + options.arm_bus : "",
               options.camera.empty() ? "" : ", depth frames at " + options.camera);
  };
  hooks.interrupted = Interrupted;
  if (terminal) {
    hooks.progress = ShowProgress;
  }
  const nlohmann::ordered_json run = RunEmulation(*scenario, options, wires, camera, hooks);
  if (terminal) {
    fmt::print(stderr, "\r\033[K");
  }
  if (options.json) {
    fmt::print("{}\n", run.dump(2));
  } else {
    fmt::print("{}", EmulationTable(run));
  }
  if (run["stop_reason"] == "bus_gone") {
    fmt::print(stderr, "pipewright: an interface was taken out of the system\n");
    return kFailed;
  }
  return kOk;
}

CLI::Option* AddRamp(CLI::App* command, const std::string& name, std::vector<double>& pair,
                     const std::string& what, double linear, double angular) {
  return command
      ->add_option(name, pair,
                   fmt::format("{}, m/s^2 and rad/s^2 ({:g} {:g})", what, linear, angular))
      ->expected(2)
      ->check(InRange(0.01, 1000));
}

void AddBase(CLI::App* command, EmulationOptions& options, RawOptions& raw) {
  TracerConfig& tracer = options.tracer;
  command
      ->add_option(
          "--modes", raw.modes,
          "what the control mode of 0x211 says by 0 to 3: sdk (standby CAN serial remote),\n"
          "tracer12 (remote CAN serial), tracer20 (standby CAN remote), mini (as sdk)")
      ->check(CLI::IsMember(ModesByName()))
      ->capture_default_str();
  command->add_option("--track", tracer.track_m, "between the wheels, m")
      ->check(InRange(0.05, 5))
      ->capture_default_str();
  command->add_option("--wheel-radius", tracer.wheel_radius_m, "m; of what the motors tell")
      ->check(InRange(0.005, 1))
      ->capture_default_str();
  command
      ->add_option("--yaw-scale", raw.yaw_scale,
                   "how much farther the base turns than it tells, slowly and fast\n"
                   "(the scenario's; a real one: 1.06 1.0)")
      ->expected(1, 2)
      ->check(InRange(0.5, 2));
  AddRamp(command, "--ramp", raw.ramp, "towards a command", tracer.accel_mps2, tracer.alpha_radps2);
  AddRamp(command, "--brake", raw.brake, "when commands stay away for 0.5 s", tracer.brake_mps2,
          tracer.brake_radps2);
  AddRamp(command, "--stop", raw.stop, "of the servo brake", tracer.stop_mps2, tracer.stop_radps2);
}

}  // namespace

void AddEmulate(CLI::App& app, int* exit_code) {
  CLI::App* command =
      app.add_subcommand("emulate", "Be the robot's base and arm on a CAN interface, in real time");
  const auto options = std::make_shared<EmulationOptions>();
  const auto raw = std::make_shared<RawOptions>();
  command
      ->add_option("--bus", options->bus,
                   "the base's CAN interface (can0, vcan0), 500 kbit/s; the arm's, too, where it\n"
                   "has none of its own. Such a bus carries both at 100 Hz, 125 Hz at most")
      ->required();
  command->add_option("--arm-bus", options->arm_bus,
                      "the arm's CAN interface, 1 Mbit/s: up to 250 Hz and more");
  command
      ->add_option("--rate", options->rate_hz,
                   "at which the host will ask the arm, Hz: what cannot fit the wire is refused")
      ->check(InRange(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--scenario", options->scenario,
                   "the world around the robot: pipes1, pipes2, pipes3, or a TOML file of your own")
      ->capture_default_str();
  command->add_option("--faults", options->faults,
                      "laid over the scenario: rough, or a TOML file of your own");
  command->add_option("--seed", options->seed, "of sensor noise and slip")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--camera", options->camera,
                      "Unix socket to make, where depth frames are to be had\n"
                      "(pipewright inspect --camera; platform/core/depth_wire.h tells the bytes)");
  AddBase(command, *options, *raw);
  command->add_flag("--no-fifo{false}", options->ask_fifo,
                    "do not ask for real-time scheduling and locked memory");
  command->add_option("--time-limit", options->time_limit_s, "end by itself after this, s")
      ->check(InRange(0.001, 1e6));
  command->add_flag("--json", options->json, "print one object, and nothing else, on stdout");
  command->callback([options, raw, exit_code] {
    TakeRaw(*raw, options->tracer);
    *exit_code = Emulate(*options, *raw);
  });
  command->footer(
      "The base is an AgileX Tracer of CAN protocol v2; the arm's seven joints are CiA 402 "
      "drives,\n"
      "nodes 1 to 7, in cyclic synchronous velocity mode, which is this project's adaptation.\n"
      "SIGINT and SIGTERM end it, with a table. Without real hardware: ip link add vcan0 type "
      "vcan.\n"
      "Exit code: 0 it was ended; 1 an interface went out of the system; 2 the input is bad.\n"
      "Example: pipewright emulate --bus vcan0 --scenario pipes1 --camera /tmp/depth &\n"
      "         pipewright inspect --bus vcan0 --scenario pipes1 --no-devices --camera /tmp/depth");
}

}  // namespace pipewright::hil
