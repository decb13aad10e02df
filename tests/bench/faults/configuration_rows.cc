// SPDX-License-Identifier: MIT
// F15: configurations that make no sense.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "ctrl/daemon/config.h"
#include "hil/world/scenario.h"
#include "tests/bench/faults/rows.h"

namespace pipewright::bench {
namespace {

struct Text {
  std::vector<std::string> lines;
  std::string With(std::size_t line, const std::string& instead) const {
    std::string text;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      text += (i == line ? instead : lines[i]) + "\n";
    }
    return text;
  }
};

Text DaemonText() {
  return {{"[can]",
           "base = \"can0\"",
           "arm = \"can1\"",
           "[base]",
           "mode_codes = \"sdk\"",
           "[control]",
           "rate_hz = 200",
           "alpha = 0.8",
           "[realtime]",
           "required = true",
           "priority = 70",
           "cpu = 3",
           "[camera]",
           "source = \"v4l2\"",
           "device = \"/dev/video2\"",
           "width = 424",
           "height = 240",
           "fx = 223.4",
           "fy = 223.4",
           "cx = 211.5",
           "cy = 119.5",
           "z_min_m = 0.168",
           "z_max_m = 6.0",
           "stamp_offset_ms = -8.5",
           "stride = 4",
           "timeout_s = 1.5",
           "[workspace]",
           "min_m = [0.1, 0.1, 0.1]",
           "max_m = [1.4, 1.4, 1.4]",
           "[start]",
           "x_m = 0.35",
           "y_m = 0.75",
           "yaw_rad = 0.25",
           "clearance_m = 0.2",
           "joints_rad = [0, -0.9, 0, 0.5, 0, -0.4, 0]",
           "[mission]",
           "planner = \"cfnbv\"",
           "seed = 7",
           "time_limit_s = 600",
           "autostart = true",
           "[watchdog]",
           "tasks_s = 2",
           "planning_s = 20",
           "[service]",
           "socket = \"/run/x/s.sock\""}};
}

Text ScenarioText() {
  return {{"name = 'test'",
           "[workspace]",
           "min_m = [0.1, 0.1, 0.1]",
           "max_m = [1.4, 1.4, 1.4]",
           "[start]",
           "x_m = 0.3",
           "y_m = 0.75",
           "yaw_rad = 0",
           "clearance_m = 0.15",
           "joints_rad = [0, -0.9, 0, 0.5, 0, -0.4, 0]",
           "[camera]",
           "rate_hz = 30",
           "[base]",
           "yaw_scale_slow = 1.06",
           "slip = 0.01",
           "[[plane]]",
           "name = 'p'",
           "normal = [0, 0, 1]",
           "offset_m = 0.0",
           "[[box]]",
           "name = 'b'",
           "center_m = [3, 3, 3]",
           "size_m = [1, 1, 1]",
           "[[cylinder]]",
           "name = 'c'",
           "from_m = [3, 0, 0]",
           "to_m = [3, 2, 0]",
           "radius_m = 0.05",
           "[[fault]]",
           "device = 'arm3'",
           "kind = 'silent'",
           "at_s = 2.5"}};
}

/// A line of `text`, from 0, and what makes a contradiction or nonsense of it.
struct BadLine {
  std::size_t line;
  std::string instead;
};

/// Each key: an unknown one in its place, another type, and, where it is a number or some, none
/// that is one, infinities, and sizes that nothing has.
std::vector<BadLine> EveryKey(const Text& text) {
  std::vector<BadLine> all;
  for (std::size_t i = 0; i < text.lines.size(); ++i) {
    const std::string& line = text.lines[i];
    const std::size_t sign = line.find(" = ");
    if (sign == std::string::npos) {
      continue;
    }
    const std::string key = line.substr(0, sign);
    const std::string value = line.substr(sign + 3);
    all.push_back({i, line + "\nno_such_key = 1"});
    all.push_back({i, line + "\n" + line});  // twice
    all.push_back({i, key + " = { a = 1 }"});
    all.push_back({i, key + " = "});
    if (value[0] == '"' || value[0] == '\'' || value == "true") {
      all.push_back({i, key + " = 3.5"});
      continue;
    }
    all.push_back({i, key + " = 'text'"});
    for (const char* bad : {"nan", "inf", "-inf", "1e300", "-1e300"}) {
      std::string instead = bad;
      if (value[0] == '[') {
        instead = "[" + std::string(bad) + value.substr(value.find(','));
      }
      all.push_back({i, key + " = " + instead});
    }
    if (value[0] == '[') {
      all.push_back({i, key + " = [1, 2]"});  // one missing, or five
    }
  }
  return all;
}

std::size_t LineOf(const Text& text, const std::string& line) {
  return static_cast<std::size_t>(std::find(text.lines.begin(), text.lines.end(), line) -
                                  text.lines.begin());
}

constexpr std::size_t kAnyLine = static_cast<std::size_t>(-1);

/// Every message begins with the file and a line; one names the line, or the one after it. What
/// contradicts another line may name that.
bool Located(const std::vector<std::string>& errors, std::size_t line) {
  bool named = false;
  for (const std::string& error : errors) {
    if (error.rfind("x.toml:", 0) != 0) {
      return false;
    }
    const auto at = static_cast<std::size_t>(std::atoi(error.c_str() + 7));
    named = named || line == kAnyLine || at == line + 1 || at == line + 2;
  }
  return named;
}

template <typename Errors>
void Try(const Text& text, const std::vector<BadLine>& bad, bool contradicts,
         const Errors& errors_of, std::uint64_t n, Tally& tally) {
  for (const BadLine& b : bad) {
    if (tally.n() >= n) {
      return;
    }
    const std::vector<std::string> errors = errors_of(text.With(b.line, b.instead));
    const bool right = Located(errors, contradicts ? kAnyLine : b.line);
    tally.Add(right ? Outcome::kSafeStop : Outcome::kWrong);
    if (!right) {
      tally.Note(fmt::format("{} -> {}", b.instead, errors.empty() ? "taken" : errors.front()));
    }
  }
}

}  // namespace

Tally BadConfigurations(std::uint64_t n, std::uint64_t) {
  Tally tally;
  const auto of_daemon = [](const std::string& text) {
    const DaemonConfigResult result = ParseDaemonConfig(text, "x.toml");
    return result.config ? std::vector<std::string>{} : result.errors;
  };
  const auto of_scenario = [](const std::string& text) {
    const hil::ScenarioResult result = hil::ParseScenario(text, "x.toml", "");
    return result.scenario ? std::vector<std::string>{} : result.errors;
  };
  const Text daemon = DaemonText();
  const Text scenario = ScenarioText();
  if (!ParseDaemonConfig(daemon.With(daemon.lines.size(), ""), "x.toml").config ||
      !hil::ParseScenario(scenario.With(scenario.lines.size(), ""), "x.toml", "").scenario) {
    tally.Add(Outcome::kWrong);
    tally.Note("what is right is refused");
    return tally;
  }
  Try(daemon, EveryKey(daemon), false, of_daemon, n, tally);
  Try(scenario, EveryKey(scenario), false, of_scenario, n, tally);
  const auto in = [&](const Text& text, const char* line, const char* instead) {
    return BadLine{LineOf(text, line), instead};
  };
  Try(daemon,
      {in(daemon, "max_m = [1.4, 1.4, 1.4]", "max_m = [1.4, 0.05, 1.4]"),
       in(daemon, "z_max_m = 6.0", "z_max_m = 0.1"), in(daemon, "rate_hz = 200", "rate_hz = 300"),
       in(daemon, "rate_hz = 200", "rate_hz = 0"),
       in(daemon, "arm = \"can1\"", "arm = \"can0\""),  // one bus does not carry 200 Hz
       in(daemon, "stride = 4", "stride = 0"), in(daemon, "alpha = 0.8", "alpha = 0.3"),
       in(daemon, "priority = 70", "priority = 0"), in(daemon, "cx = 211.5", "cx = 500"),
       in(daemon, "mode_codes = \"sdk\"", "mode_codes = \"none\""),
       in(daemon, "joints_rad = [0, -0.9, 0, 0.5, 0, -0.4, 0]",
          "joints_rad = [0, -0.9, 0, 5.0, 0, -0.4, 0]")},
      true, of_daemon, n, tally);
  Try(scenario,
      {in(scenario, "max_m = [1.4, 1.4, 1.4]", "max_m = [1.4, 1.4, 0.1]"),
       in(scenario, "normal = [0, 0, 1]", "normal = [0, 0, 0]"),
       in(scenario, "to_m = [3, 2, 0]", "to_m = [3, 0, 0]"),
       in(scenario, "size_m = [1, 1, 1]", "size_m = [1, 0, 1]"),
       in(scenario, "device = 'arm3'", "device = 'arm8'"),
       in(scenario, "kind = 'silent'", "kind = 'loud'")},
      true, of_scenario, n, tally);
  return tally;
}

}  // namespace pipewright::bench
