// SPDX-License-Identifier: MIT
#include "hil/cli/replay_figures.h"

#include <fmt/format.h>

#include <string_view>

#include "hil/canlog/frame_decoder.h"
#include "hil/cli/canlog_input.h"
#include "hil/cli/canlog_signals.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

std::string Text(const SignalValue& signal) {
  fmt::memory_buffer text;
  if (signal.has_name()) {
    signal.append_name(text, static_cast<std::uint32_t>(signal.value), ControlModesNamed("sdk"));
  } else {
    AppendValue(text, signal.value);
    if (signal.unit != "1") {
      fmt::format_to(std::back_inserter(text), " {}", signal.unit);
    }
  }
  return fmt::to_string(text);
}

/// A frame of a difference, decoded.
Json FrameJson(const std::optional<LogFrame>& frame) {
  if (!frame) {
    return nullptr;
  }
  Json signals = Json::object();
  DecodedFrame decoded;
  if (DecodeFrame(*frame, decoded) == Status::kOk) {
    for (const SignalValue& signal : decoded.signals) {
      signals[std::string(signal.name)] = Text(signal);
    }
  }
  return {{"t_s", 1e-9 * static_cast<double>(frame->stamp_ns)},
          {"payload", PayloadText(*frame)},
          {"signals", signals}};
}

Json CountsJson(const CommandCounts& counts) {
  return {{"same", counts.same},
          {"different", counts.different},
          {"not_replayed", counts.not_replayed},
          {"not_recorded", counts.not_recorded}};
}

Json FirstJson(const std::optional<CommandDifference>& first) {
  if (!first) {
    return nullptr;
  }
  const LogFrame& frame = first->recorded ? *first->recorded : *first->replayed;
  IdKey key = KeyOf(frame);
  key.channel = 0;
  return {{"t_s", ToSeconds(first->at())},
          {"id", IdText(key)},
          {"name", FrameName(key)},
          {"recorded", FrameJson(first->recorded)},
          {"replayed", FrameJson(first->replayed)}};
}

Json CompareJson(const CommandComparison& comparison) {
  Json ids = Json::array();
  for (const CommandComparison::Entry* const entry : comparison.Sorted()) {
    Json id = {{"id", IdText(entry->key)}, {"name", FrameName(entry->key)}};
    id.update(CountsJson(entry->value));
    ids.push_back(std::move(id));
  }
  Json json = {{"identical", comparison.differences() == 0}};
  json.update(CountsJson(comparison.total()));
  json["first_difference"] = FirstJson(comparison.first());
  json["ids"] = std::move(ids);
  return json;
}

std::string SideText(const Json& frame, const char* none) {
  if (frame.is_null()) {
    return none;
  }
  std::string text = fmt::format("{}", frame["payload"].get<std::string>());
  for (const auto& [name, value] : frame["signals"].items()) {
    text += fmt::format("  {} {}", name, value.get<std::string>());
  }
  return text;
}

std::string CompareText(const Json& compare) {
  const auto count = [](const Json& of, const char* name) { return of[name].get<std::uint64_t>(); };
  if (compare["identical"]) {
    return fmt::format("  commands   {} of {}, byte for byte the same\n", count(compare, "same"),
                       count(compare, "same"));
  }
  std::string text = fmt::format(
      "  commands   they differ: {} are the same, {} different, {} only recorded, {} only "
      "replayed\n",
      count(compare, "same"), count(compare, "different"), count(compare, "not_replayed"),
      count(compare, "not_recorded"));
  text += fmt::format("\n  {:<8} {:<24} {:>10} {:>10} {:>14} {:>14}\n", "id", "frame", "same",
                      "different", "only recorded", "only replayed");
  for (const Json& id : compare["ids"]) {
    text += fmt::format("  {:<8} {:<24} {:>10} {:>10} {:>14} {:>14}\n", id["id"].get<std::string>(),
                        id["name"].get<std::string>(), count(id, "same"), count(id, "different"),
                        count(id, "not_replayed"), count(id, "not_recorded"));
  }
  const Json& first = compare["first_difference"];
  text += fmt::format(
      "\n  first difference: {:.6f} s, {} {}\n    recorded  {}\n    replayed  {}\n",
      first["t_s"].get<double>(), first["id"].get<std::string>(), first["name"].get<std::string>(),
      SideText(first["recorded"], "no such frame"), SideText(first["replayed"], "no such frame"));
  return text;
}

}  // namespace

Json ReplayJson(const ReplayFiles& files, const RecordedBus& bus, const DepthReader* depth,
                Json program, bool compare) {
  Json log = FilesJson(bus.log()).front();
  log["from_devices"] = bus.states();
  log["from_robot"] = bus.commands();
  log["passed_over"] = bus.passed_over();
  log["beyond_silence"] = bus.beyond_silence();
  Json json;
  json["log"] = std::move(log);
  json["run"] = files.run;
  json["depth"] = nullptr;
  if (depth != nullptr) {
    const std::string end = depth->end();
    json["depth"] = {{"path", files.depth},
                     {"frames", depth->frames()},
                     {"ends_early", end.empty() ? Json(nullptr) : Json(end)}};
  }
  json["program"] = std::move(program);
  json["compare"] = compare ? CompareJson(bus.comparison()) : Json(nullptr);
  return json;
}

std::string ReplayTable(const Json& replay) {
  const Json& log = replay["log"];
  const Json& program = replay["program"];
  const double replayed_s = program["replayed_s"];
  const double wall_s = program["wall_time_s"];
  std::string text = fmt::format(
      "  replayed   {:.1f} s in {:.1f} s ({:.1f}x): {} frames of {}, {}\n", replayed_s, wall_s,
      wall_s > 0 ? replayed_s / wall_s : 0,
      log["from_devices"].get<std::uint64_t>() + log["from_robot"].get<std::uint64_t>(),
      log["format"].get<std::string>(),
      replay["depth"].is_null()
          ? "no depth frames"
          : fmt::format("{} depth frames", program["depth_frames"].get<std::uint64_t>()));
  const std::string stop = program["stop_reason"];
  const std::string detail = program["stop_detail"];
  const std::string state = program["state"];
  text += fmt::format("  program    {}{}; {} cycles, {} plans\n", stop == "none" ? state : stop,
                      detail.empty() ? "" : ": " + detail, program["cycles"].get<std::uint64_t>(),
                      program["plan_steps"].get<int>());
  return replay["compare"].is_null() ? text : text + CompareText(replay["compare"]);
}

}  // namespace pipewright::hil
