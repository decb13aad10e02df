// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <map>

#include "hil/cli/emulate_run.h"
#include "hil/cli/table_rows.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

std::string Wire(const Json& wire) {
  std::string text = fmt::format(
      "{} frames out, {} in, {} + {} dropped, load {:.0f} % (at most {:.0f} % foreseen)",
      wire["tx"].get<std::uint64_t>(), wire["rx"].get<std::uint64_t>(),
      wire["tx_dropped"].get<std::uint64_t>(), wire["rx_dropped"].get<std::uint64_t>(),
      100 * wire["load_peak"].get<double>(), 100 * wire["load_expected"].get<double>());
  const auto add = [&](const char* key, const char* words) {
    if (const auto count = wire[key].get<std::uint64_t>(); count > 0) {
      text += fmt::format(", {} {}", count, words);
    }
  };
  add("emergencies", "EMCY");
  add("error_frames", "error frames");
  add("bus_off", "of them bus-off");
  add("link_losses", "times down");
  return text;
}

/// "7 operation enabled", or how many are in which state.
std::string States(const Json& joints) {
  std::map<std::string, int> states;
  for (const Json& joint : joints) {
    ++states[joint["state"].get<std::string>()];
  }
  std::string text;
  for (const auto& [state, count] : states) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, state);
  }
  return text;
}

}  // namespace

std::string EmulationTable(const Json& run) {
  const Json& base = run["base"];
  const Json& arm = run["arm"];
  const Json& camera = run["camera"];
  const Json& truth = run["truth"];
  const Json& realtime = run["realtime"];
  TableRows row;
  row("ended", fmt::format("{} after {:.1f} s", run["stop_reason"].get<std::string>(),
                           run["time_s"].get<double>()));
  for (const Json& wire : run["bus"]) {
    row(wire["interface"], fmt::format("{}: {}", wire["carries"].get<std::string>(), Wire(wire)));
  }
  row("base", fmt::format("{:.3f} m travelled, {} watchdog stops, {} commands refused{}",
                          base["travel_m"].get<double>(), base["watchdog_trips"].get<int>(),
                          base["rejected"].get<int>(),
                          base["can_mode"].get<bool>() ? ", under CAN control" : ""));
  row("arm", fmt::format("{:.3f} rad travelled, {} hard stops; {}", arm["travel_rad"].get<double>(),
                         arm["hard_stops"].get<int>(), States(arm["joints"])));
  if (!camera["socket"].get<std::string>().empty()) {
    row("camera", fmt::format("{} frames, {} skipped, {} readers", camera["frames"].get<int>(),
                              camera["skipped"].get<int>(), camera["readers"].get<int>()));
  }
  row("contacts", fmt::format("{}", truth["contacts"].get<int>()));
  row("coverage", fmt::format("{:.1f} % ({} of {} coverable surface voxels)",
                              100 * truth["coverage"].get<double>(), truth["covered"].get<int>(),
                              truth["coverable"].get<int>()));
  row("clock", fmt::format("{:.1f} ms late at most, {} stalls; SCHED_FIFO {}",
                           realtime["late_max_ms"].get<double>(), realtime["stalls"].get<int>(),
                           realtime["fifo"].get<std::string>()));
  return row.text;
}

}  // namespace pipewright::hil
