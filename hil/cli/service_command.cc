// SPDX-License-Identifier: MIT
#include "hil/cli/service_command.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

namespace pipewright::hil {
namespace {

constexpr int kOk = 0;
constexpr int kRefused = 1;
constexpr int kBadInput = 2;
constexpr std::size_t kMostBytes = 1 << 16;
constexpr int kPatience_s = 5;

struct ServiceOptions {
  std::string socket = "/run/pipewright/status.sock";
  bool json = false;
};

struct Reply {
  std::string line;   ///< without its end
  std::string error;  ///< set, in words, when there is no reply
};

/// Everything up to the line's end, or what went wrong.
Reply Talk(int stream, const std::string& request) {
  const std::string line = request + "\n";
  if (send(stream, line.data(), line.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(line.size())) {
    return {"", std::strerror(errno)};
  }
  Reply reply;
  char bytes[4096];
  while (reply.line.size() < kMostBytes) {
    const ssize_t got = recv(stream, bytes, sizeof bytes, 0);
    if (got <= 0) {
      return {"", got == 0 ? "it hung up"
                           : (errno == EAGAIN ? "it does not answer" : std::strerror(errno))};
    }
    reply.line.append(bytes, static_cast<std::size_t>(got));
    if (const std::size_t end = reply.line.find('\n'); end != std::string::npos) {
      reply.line.resize(end);
      return reply;
    }
  }
  return {"", "its answer has no end"};
}

Reply Ask(const std::string& path, const std::string& request) {
  sockaddr_un address{};
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    return {"", "no path that a socket can have"};
  }
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, path.size());
  const int stream = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (stream < 0) {
    return {"", std::strerror(errno)};
  }
  const timeval patience{.tv_sec = kPatience_s, .tv_usec = 0};
  setsockopt(stream, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  setsockopt(stream, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  Reply reply;
  if (connect(stream, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    reply = Talk(stream, request);
  } else {
    const char* hint = errno == EACCES   ? "; operators are in the group pipewright"
                       : errno == ENOENT ? "; is pipewrightd running?"
                                         : "";
    reply.error = std::string(std::strerror(errno)) + hint;
  }
  close(stream);
  return reply;
}

/// Throws what .at() and .get() do: the answer may be of another version.
std::string Device(const nlohmann::json& report, const char* name) {
  return fmt::format("{} on {}", report.at(name).at("heard").get<bool>() ? "heard" : "silent",
                     report.at("bus").at(name).get<std::string>());
}

std::string StatusTable(const nlohmann::json& r) {
  const nlohmann::json& run = r.at("run");
  const auto text = [](const nlohmann::json& value) { return value.get<std::string>(); };
  std::string out;
  const auto row = [&out](const char* name, const std::string& value) {
    out += fmt::format("{:<9} {}\n", name, value);
  };
  const std::string reason = text(r.at("reason"));
  row("state", text(r.at("state")) + (reason.empty() ? "" : ": " + reason) +
                   (r.at("latched").get<bool>() ? " (latched: pipewright rearm)" : ""));
  const std::string bus = text(r.at("bus").at("error"));
  row("bus", bus.empty() ? "open" : bus);
  const double battery_V = r.at("base").at("battery_V").get<double>();
  row("base",
      Device(r, "base") + (battery_V > 0 ? fmt::format(", {:.1f} V", battery_V) : "") +
          (r.at("base").at("emergency_stop").get<bool>() ? ", emergency stop pressed" : ""));
  row("arm", Device(r, "arm"));
  const std::string camera = text(r.at("camera").at("error"));
  row("camera",
      camera.empty() ? fmt::format("{} frames", r.at("camera").at("frames").get<int>()) : camera);
  row("real time",
      fmt::format("SCHED_FIFO {}, memory {}",
                  r.at("realtime").at("fifo").get<bool>() ? "yes" : "no",
                  r.at("realtime").at("memory_locked").get<bool>() ? "locked" : "not locked"));
  if (run.at("number").get<int>() > 0) {
    const nlohmann::json& voxels = run.at("voxels");
    row("run", fmt::format("{}, {:.0f} s, mission {}, devices {}", run.at("number").get<int>(),
                           run.at("time_s").get<double>(), text(run.at("mission")),
                           text(run.at("phase"))));
    row("map", fmt::format("{} of {} voxels unknown, {} of {} occupied covered",
                           voxels.at("unknown").get<int>(), voxels.at("total").get<int>(),
                           voxels.at("covered").get<int>(), voxels.at("occupied").get<int>()));
    row("pose", fmt::format("x {:.3f} m, y {:.3f} m, phi {:.3f} rad", run.at("x_m").get<double>(),
                            run.at("y_m").get<double>(), run.at("phi_rad").get<double>()));
    row("cycles",
        fmt::format("{}, {} missed, at most {:.0f} us late, {:.0f} us long",
                    run.at("cycles").get<long>(), run.at("missed").get<long>(),
                    run.at("latency_max_us").get<double>(), run.at("cycle_max_us").get<double>()));
  }
  return out;
}

int Request(const std::string& word, const ServiceOptions& options) {
  const Reply reply = Ask(options.socket, word);
  if (!reply.error.empty()) {
    fmt::print(stderr, "pipewright: {}: {}\n", options.socket, reply.error);
    return kBadInput;
  }
  const nlohmann::json answer = nlohmann::json::parse(reply.line, nullptr, false);
  if (!answer.is_object() || !answer.contains("ok") || !answer["ok"].is_boolean()) {
    fmt::print(stderr, "pipewright: {}: what answers there is not pipewrightd\n", options.socket);
    return kBadInput;
  }
  const bool ok = answer["ok"].get<bool>();
  if (options.json) {
    fmt::print("{}\n", reply.line);
  } else if (!ok) {
    fmt::print(stderr, "pipewright: {} refused: {}\n", word, answer.value("error", "no reason"));
  } else if (word == "status") {
    try {
      fmt::print("{}", StatusTable(answer));
    } catch (const nlohmann::json::exception& error) {
      fmt::print(stderr, "pipewright: {}: a status of another version: {}\n", options.socket,
                 error.what());
      return kBadInput;
    }
  }
  return ok ? kOk : kRefused;
}

}  // namespace

void AddService(CLI::App& app, int* exit_code) {
  const struct {
    const char* word;
    const char* help;
  } kWords[] = {
      {"status", "What pipewrightd and its robot are doing"},
      {"start", "Have pipewrightd switch the robot on and run its mission"},
      {"stop", "Have it bring the robot to rest and disable it"},
      {"estop", "The same at once and from any state, latched until rearm, even over a restart"},
      {"rearm", "After a run has ended or an emergency stop: be ready for a start again"},
  };
  for (const auto& one : kWords) {
    CLI::App* command = app.add_subcommand(one.word, one.help);
    const auto options = std::make_shared<ServiceOptions>();
    command->add_option("--socket", options->socket, "of pipewrightd (its service.socket)")
        ->capture_default_str();
    command->add_flag("--json", options->json, "print its answer, one object, and nothing else");
    command->callback([word = std::string(one.word), options, exit_code] {
      *exit_code = Request(word, *options);
    });
    command->footer("Exit code: 0 done; 1 pipewrightd refuses, and says why; 2 nobody answers.");
  }
}

}  // namespace pipewright::hil
