// SPDX-License-Identifier: MIT
#include "hil/cli/canlog_mcap.h"

#include <fmt/format.h>

#include <algorithm>

#include "hil/canlog/frame_sorter.h"
#include "hil/cli/can_to_ros.h"
#include "hil/cli/canlog_signals.h"

namespace pipewright::hil {
namespace {

struct Figures {
  std::uint64_t frames = 0;
  std::uint64_t without_time = 0;
  std::uint64_t bytes = 0;
  std::vector<CanToRos::TopicFigures> topics;
};

/// @returns an error in words, or nothing
std::string WriteMcap(LogSet& log, std::span<const LogFrame> first, const CanlogOptions& options,
                      Figures& figures) {
  McapWriter file;
  if (std::string error = file.Open(options.mcap, "ros2"); !error.empty()) {
    return error;
  }
  CanToRos to_ros(file, log.channels(), ControlModesNamed(options.modes));
  FrameSorter sorter;
  const auto take = [&to_ros](const LogFrame& frame) { to_ros.Take(frame); };
  for (auto frames = first; !frames.empty() && !file.failed(); frames = log.Next()) {
    for (const LogFrame& frame : frames) {
      ++figures.frames;
      if (frame.stamped) {
        sorter.Add(frame, take);
      } else {
        ++figures.without_time;
      }
    }
  }
  sorter.End(take);
  to_ros.End();
  figures.topics = to_ros.Figures();
  std::string error = file.Close();
  figures.bytes = file.bytes();
  return error;
}

std::string Text(const CanlogOptions& options, const Figures& figures) {
  std::string text =
      fmt::format("{}: {} bytes from {} frames\n", options.mcap, figures.bytes, figures.frames);
  for (const CanToRos::TopicFigures& topic : figures.topics) {
    text += fmt::format("{:<24} {:>10}  {}\n", topic.topic, topic.messages, topic.type);
  }
  return text;
}

nlohmann::ordered_json Json(const LogSet& log, const CanlogOptions& options,
                            const Figures& figures) {
  nlohmann::ordered_json topics = nlohmann::ordered_json::array();
  for (const CanToRos::TopicFigures& topic : figures.topics) {
    topics.push_back({{"topic", topic.topic}, {"type", topic.type}, {"messages", topic.messages}});
  }
  return {{"mcap", options.mcap},     {"bytes", figures.bytes},
          {"frames", figures.frames}, {"frames_without_time", figures.without_time},
          {"topics", topics},         {"files", FilesJson(log)}};
}

}  // namespace

int CanlogMcap(LogSet& log, const CanlogOptions& options) {
  if (options.every_s > 0 || !options.signals.empty()) {
    return Refuse("export --mcap: goes without --every and --signal: messages have all there is");
  }
  // Before the file is made: a log that cannot be read leaves none.
  const std::span<const LogFrame> first = log.Next();
  if (!log.error().empty()) {
    return TellProblems(log);
  }
  Figures figures;
  if (const std::string error = WriteMcap(log, first, options, figures); !error.empty()) {
    fmt::print(stderr, "pipewright: {}: cannot be written: {}\n", options.mcap, error);
    return std::max(TellProblems(log), kCanlogFailed);
  }
  if (figures.without_time > 0) {
    fmt::print(stderr, "pipewright: {} frames have no time and are left out\n",
               figures.without_time);
  }
  const int printed =
      Print(options.json ? Dump(Json(log, options, figures)) : Text(options, figures));
  return std::max(TellProblems(log), printed);
}

}  // namespace pipewright::hil
