// SPDX-License-Identifier: MIT
#include "hil/cli/gateway_command.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <memory>

#include "hil/cli/gateway_run.h"
#include "hil/cli/in_range.h"
#include "hil/cli/interrupts.h"
#include "platform/can/cia402.h"
#include "platform/robot/uf7.h"

namespace pipewright::hil {
namespace {

constexpr int kOk = 0;
constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr double kInsideLimits_rad = 0.01;  ///< of the nodes' soft limits

/// What the command line gives in another shape than GatewayOptions.
struct RawOptions {
  int report = 30003;
  int report_port = 0;
  double duration_ms = 40;
};

/// The first IPv4 address of a host. @param error  set, in words, when it has none
std::string Resolve(const std::string& host, std::string& error) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int status = getaddrinfo(host.c_str(), nullptr, &hints, &found); status != 0) {
    error = fmt::format("--controller {}: {}", host, gai_strerror(status));
    return "";
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, freeaddrinfo);
  char text[INET_ADDRSTRLEN] = {};
  const auto* address = reinterpret_cast<const sockaddr_in*>(found->ai_addr);
  inet_ntop(AF_INET, &address->sin_addr, text, sizeof text);
  return text;
}

void Configure(const RawOptions& raw, XarmGatewayConfig& config) {
  config.controller.report =
      raw.report == 30003 ? XarmReportKind::kReal : XarmReportKind::kRealTime;
  config.controller.report_port = raw.report_port != 0 ? raw.report_port : raw.report;
  config.velocity_duration = FromSeconds(raw.duration_ms * 1e-3);
  config.lower_rad = JointValues(TracerUf7(), &ArmJoint::q_min_rad).array() + kInsideLimits_rad;
  config.upper_rad = JointValues(TracerUf7(), &ArmJoint::q_max_rad).array() - kInsideLimits_rad;
}

void ShowProgress(const GatewayProgress& p) {
  std::string line = fmt::format("{}, {} joints enabled, {} velocities sent", Name(p.phase),
                                 p.joints_enabled, p.velocities);
  if (!p.trouble.empty()) {
    line += ": " + p.trouble;
  } else if (p.measured) {
    line += ", at";
    for (int i = 0; i < kXarmJoints; ++i) {
      line += fmt::format(" {:.2f}", p.position_rad(i));
    }
    line += " rad";
  }
  fmt::print(stderr, "\r\033[K{}", line);
  std::fflush(stderr);
}

int Serve(GatewayOptions& options, const RawOptions& raw) {
  Configure(raw, options.config);
  std::string error;
  options.config.controller.address = Resolve(options.controller, error);
  WirePort wire(options.bus, can::kArmBitrate);
  error = error.empty() ? wire.Open("--bus") : error;
  if (!error.empty()) {
    fmt::print(stderr, "pipewright: {}\n", error);
    return kBadInput;
  }
  CatchInterrupts();
  const bool terminal = isatty(STDERR_FILENO) == 1;
  fmt::print(stderr, "pipewright: {} ({}) as nodes 1 to 7 on {}; Ctrl-C ends it\n",
             options.controller, options.config.controller.address, options.bus);
  GatewayHooks hooks;
  hooks.interrupted = Interrupted;
  if (terminal) {
    hooks.progress = ShowProgress;
  }
  const nlohmann::ordered_json run = RunGateway(options, wire, hooks);
  if (terminal) {
    fmt::print(stderr, "\r\033[K");
  }
  if (options.json) {
    fmt::print("{}\n", run.dump(2));
  } else {
    fmt::print("{}", GatewayTable(run));
  }
  if (run["stop_reason"] == "refused") {
    fmt::print(stderr, "pipewright: {}: {}\n", options.controller,
               run["controller"]["trouble"].get<std::string>());
    return kFailed;
  }
  if (run["stop_reason"] == "bus_gone") {
    fmt::print(stderr, "pipewright: the interface was taken out of the system\n");
    return kFailed;
  }
  return kOk;
}

}  // namespace

void AddGateway(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "gateway",
      "Put a UFACTORY controller of a 7-joint arm on a CAN interface, as CiA 402 drives");
  const auto options = std::make_shared<GatewayOptions>();
  const auto raw = std::make_shared<RawOptions>();
  command
      ->add_option("--controller", options->controller,
                   "host name or IPv4 address of the controller; beside it, nothing else may\n"
                   "command the arm: UFACTORY Studio in motion is somebody who takes it over")
      ->required();
  command
      ->add_option("--bus", options->bus,
                   "the arm's CAN interface (can1, vcan0); the robot program may be on this\n"
                   "computer or on another one of that bus")
      ->required();
  command
      ->add_option("--report", raw->report,
                   "where joint positions come from: 30003, 100 Hz, or 30000, 200 Hz with\n"
                   "velocities, of firmware 2.1.0 and later")
      ->check(CLI::IsMember({30003, 30000}))
      ->capture_default_str();
  command
      ->add_option("--duration", raw->duration_ms,
                   "after which the controller ends each velocity by itself, ms: what stops the\n"
                   "arm should this computer be gone")
      ->check(InRange(30, 1000))
      ->capture_default_str();
  command
      ->add_option("--port", options->config.controller.request_port,
                   "of the controller's requests")
      ->check(CLI::Range(1, 65535))
      ->capture_default_str();
  command
      ->add_option("--report-port", raw->report_port,
                   "of its reports, where they are not to be had at the port that --report names")
      ->check(CLI::Range(1, 65535));
  command->add_flag("--no-fifo{false}", options->ask_fifo,
                    "do not ask for real-time scheduling and locked memory");
  command->add_option("--time-limit", options->time_limit_s, "end by itself after this, s")
      ->check(InRange(0.001, 1e6));
  command->add_flag("--json", options->json, "print one object, and nothing else, on stdout");
  command->callback([options, raw, exit_code] { *exit_code = Serve(*options, *raw); });
  command->footer(
      "UFACTORY has no CAN interface for its arms: the seven nodes are this project's adaptation.\n"
      "They boot when the controller has reported where the joints stand, and are enabled when it\n"
      "has reported mode 4 and a state that moves. Velocities (60FFh) of one SYNC are one "
      "request.\n"
      "Faults, of all nodes: EMCY 0x7500 the controller is silent or gone; 0x9000 somebody else "
      "has\n"
      "changed its mode or state (teach mode, the stop button, another client): nothing is sent\n"
      "until the host resets the fault; 0xFF00 it has an error, whose number follows; 0xFF01 it\n"
      "refused a request. A reset has it asked afresh and its error cleaned; ask again until the\n"
      "fault is gone.\n"
      "SIGINT and SIGTERM end it, with a table; an arm at work is told to stop first.\n"
      "Exit code: 0 it was ended; 1 the controller is none to work with (7 axes, firmware 1.8.0 "
      "or\n"
      "later), or the interface went out of the system; 2 the input is bad.\n"
      "Example: pipewright gateway --controller 192.168.1.203 --bus can1 &\n"
      "         pipewright inspect --bus can0,can1 --no-devices --camera /tmp/depth");
}

}  // namespace pipewright::hil
