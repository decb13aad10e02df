// SPDX-License-Identifier: MIT
#include "hil/cli/canlog_mcap.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "hil/canlog/frame_sorter.h"
#include "hil/cli/can_to_ros.h"
#include "hil/cli/canlog_signals.h"
#include "hil/cli/depth_to_ros.h"

namespace pipewright::hil {
namespace {

struct Figures {
  std::uint64_t frames = 0;
  std::uint64_t without_time = 0;
  std::uint64_t bytes = 0;
  std::vector<RosTopics::Figures> topics;
  std::optional<DepthToRos::Figures> depth;
  std::string depth_end;  ///< why the depth recording ends early; empty if it does not
};

/// @param depth  null: none is asked for
/// @returns an error in words, or nothing
std::string WriteMcap(LogSet& log, std::span<const LogFrame> first, DepthReader* depth,
                      const CanlogOptions& options, Figures& figures) {
  McapWriter file;
  if (std::string error = file.Open(options.mcap, "ros2"); !error.empty()) {
    return error;
  }
  RosTopics topics(file);
  CanToRos to_ros(topics, log.channels(), ControlModesNamed(options.modes));
  std::optional<DepthToRos> depth_to_ros;
  if (depth != nullptr) {
    depth_to_ros.emplace(topics, *depth, options.points_every);
  }
  FrameSorter sorter;
  const auto take = [&](const LogFrame& frame) {
    if (depth_to_ros) {
      depth_to_ros->Take(frame);
    }
    to_ros.Take(frame);
  };
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
  if (depth_to_ros) {
    depth_to_ros->End();
    figures.depth = depth_to_ros->figures();
    figures.depth_end = depth->end();
  }
  figures.topics = topics.All();
  std::string error = file.Close();
  figures.bytes = file.bytes();
  return error;
}

/// That no depth frame is of the log's time, in words, or nothing.
std::string Apart(const CanlogOptions& options, const DepthToRos::Figures& depth) {
  if (depth.written > 0 || depth.outside == 0) {
    return "";
  }
  const std::string log = fmt::format("{}", fmt::join(options.files, ", "));
  return fmt::format(
      "{}: its depth frames are of {} to {} s, {}: no export, since none is of the log's time",
      options.depth, StampText(depth.first_ns), StampText(depth.last_ns),
      depth.log_first_ns ? fmt::format("the frames of {} of {} to {} s", log,
                                       StampText(*depth.log_first_ns), StampText(depth.log_last_ns))
                         : fmt::format("and no frame of {} has a time", log));
}

std::string Text(const CanlogOptions& options, const Figures& figures) {
  std::string text =
      fmt::format("{}: {} bytes from {} frames\n", options.mcap, figures.bytes, figures.frames);
  for (const RosTopics::Figures& topic : figures.topics) {
    text += fmt::format("{:<24} {:>10}  {}\n", topic.topic, topic.messages, topic.type);
  }
  if (const auto& depth = figures.depth) {
    text += fmt::format(
        "{}: {} depth frames; {} are outside the log's time and left out, of {} the joints are not "
        "known\n",
        options.depth, depth->written + depth->outside, depth->outside, depth->without_joints);
  }
  return text;
}

nlohmann::ordered_json Json(const LogSet& log, const CanlogOptions& options,
                            const Figures& figures) {
  using Object = nlohmann::ordered_json;
  Object topics = Object::array();
  for (const RosTopics::Figures& topic : figures.topics) {
    topics.push_back({{"topic", topic.topic}, {"type", topic.type}, {"messages", topic.messages}});
  }
  Object json = {{"mcap", options.mcap},     {"bytes", figures.bytes},
                 {"frames", figures.frames}, {"frames_without_time", figures.without_time},
                 {"topics", topics},         {"files", FilesJson(log)},
                 {"depth", nullptr}};
  if (const auto& depth = figures.depth) {
    json["depth"] = {
        {"path", options.depth},
        {"frames", depth->written + depth->outside},
        {"outside_log", depth->outside},
        {"without_joints", depth->without_joints},
        {"ends_early", figures.depth_end.empty() ? Object(nullptr) : Object(figures.depth_end)}};
  }
  return json;
}

/// Says on standard error what of log and depth frames was left out. @returns the exit code
int TellLeftOut(const LogSet& log, const CanlogOptions& options, const Figures& figures) {
  if (figures.without_time > 0) {
    fmt::print(stderr, "pipewright: {} frames have no time and are left out\n",
               figures.without_time);
  }
  if (!figures.depth_end.empty()) {
    fmt::print(stderr, "pipewright: {}: {}\n", options.depth, figures.depth_end);
  }
  return std::max(TellProblems(log), figures.depth_end.empty() ? kCanlogOk : kCanlogFailed);
}

}  // namespace

int CanlogMcap(LogSet& log, const CanlogOptions& options) {
  if (options.every_s > 0 || !options.signals.empty()) {
    return Refuse("export --mcap: goes without --every and --signal: messages have all there is");
  }
  // Before the file is made: a log or depth frames that cannot be read leave none.
  const std::span<const LogFrame> first = log.Next();
  if (!log.error().empty()) {
    return TellProblems(log);
  }
  DepthReader depth;
  const bool sees = !options.depth.empty();
  if (const std::string error = sees ? depth.Open(options.depth) : ""; !error.empty()) {
    return Refuse(error);
  }
  Figures figures;
  if (const std::string error = WriteMcap(log, first, sees ? &depth : nullptr, options, figures);
      !error.empty()) {
    fmt::print(stderr, "pipewright: {}: cannot be written: {}\n", options.mcap, error);
    return std::max(TellProblems(log), kCanlogFailed);
  }
  const int left_out = TellLeftOut(log, options, figures);
  if (const std::string error = sees ? Apart(options, *figures.depth) : ""; !error.empty()) {
    std::error_code failed;
    if (std::filesystem::is_regular_file(options.mcap, failed)) {
      std::filesystem::remove(options.mcap, failed);
    }
    return Refuse(error);
  }
  const int printed =
      Print(options.json ? Dump(Json(log, options, figures)) : Text(options, figures));
  return std::max(left_out, printed);
}

}  // namespace pipewright::hil
