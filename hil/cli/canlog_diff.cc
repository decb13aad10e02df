// SPDX-License-Identifier: MIT
#include "hil/cli/canlog_diff.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "hil/canlog/log_diff.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMsPerS = 1e3;

Json FrameJson(const std::optional<LogFrame>& frame) {
  if (!frame) {
    return nullptr;
  }
  return {{"t_s", frame->stamped ? Json(1e-9 * static_cast<double>(frame->stamp_ns)) : Json()},
          {"payload", PayloadText(*frame)}};
}

/// The id that parts first, by the times of both logs: what follows may only be its consequence.
const LogDiff::Entry* FirstToPart(const LogDiff& diff) {
  const LogDiff::Entry* earliest = nullptr;
  const auto time_of = [](const LogDiff::Entry* entry) {
    std::int64_t ns = INT64_MAX;
    for (const std::optional<LogFrame>& frame : entry->value.first->frames) {
      ns = frame && frame->stamped ? std::min(ns, frame->stamp_ns) : ns;
    }
    return ns;
  };
  for (const LogDiff::Entry* const entry : diff.Sorted()) {
    if (entry->value.first && (earliest == nullptr || time_of(entry) < time_of(earliest))) {
      earliest = entry;
    }
  }
  return earliest;
}

Json DiffJson(const LogDiff& diff, const std::array<CanlogInput, 2>& inputs) {
  Json ids = Json::array();
  bool same = diff.frames_beyond() == 0;
  for (const LogDiff::Entry* const entry : diff.Sorted()) {
    const IdDiff& id = entry->value;
    const bool timed = id.later.count() > 0;
    same = same && !id.differs() && !id.given_up;
    ids.push_back(
        {{"id", IdText(entry->key)},
         {"name", FrameName(entry->key)},
         {"frames", id.frames},
         {"same", id.same},
         {"first_difference", id.first ? Json({{"index", id.first->index},
                                               {"first", FrameJson(id.first->frames[0])},
                                               {"second", FrameJson(id.first->frames[1])}})
                                       : Json(nullptr)},
         {"given_up", id.given_up},
         {"later_s", timed ? Json({{"min", id.later.min_s()},
                                   {"mean", id.later.mean_s()},
                                   {"max", id.later.max_s()},
                                   {"deviation", id.later.deviation_s()}})
                           : Json(nullptr)}});
  }
  Json files = FilesJson(inputs[0].log());
  files.insert(files.end(), FilesJson(inputs[1].log()).front());
  const LogDiff::Entry* const part = FirstToPart(diff);
  return {{"same", same},
          {"parts_first", part != nullptr ? Json(IdText(part->key)) : Json(nullptr)},
          {"ids", ids},
          {"frames_beyond_ids", diff.frames_beyond()},
          {"files", files}};
}

std::string SideText(const std::optional<LogFrame>& frame) {
  if (!frame) {
    return "no such frame";
  }
  return fmt::format("{} '{}'", frame->stamped ? StampText(frame->stamp_ns) : "-",
                     PayloadText(*frame));
}

std::string DiffText(const LogDiff& diff, const CanlogOptions& options) {
  std::string text = fmt::format(
      "first:  {}\nsecond: {}\nlater: by how much the second log has "
      "frames later, each from its log's first frame\n\n",
      options.files[0], options.files[1]);
  text += fmt::format("{:<8} {:<24} {:>10} {:>10} {:>10} {:>12} {:>12} {:>12}\n", "id", "frame",
                      "first", "second", "same", "later min ms", "mean ms", "max ms");
  std::string differences;
  for (const LogDiff::Entry* const entry : diff.Sorted()) {
    const IdDiff& id = entry->value;
    text += fmt::format("{:<8} {:<24} {:>10} {:>10} {:>10} {:>12.3f} {:>12.3f} {:>12.3f}\n",
                        IdText(entry->key), FrameName(entry->key), id.frames[0], id.frames[1],
                        id.same, kMsPerS * id.later.min_s(), kMsPerS * id.later.mean_s(),
                        kMsPerS * id.later.max_s());
    if (id.first) {
      differences += fmt::format("{} {}: frame {} differs: {} | {}\n", IdText(entry->key),
                                 FrameName(entry->key), id.first->index,
                                 SideText(id.first->frames[0]), SideText(id.first->frames[1]));
    }
    if (id.given_up) {
      differences +=
          fmt::format("{} {}: one log got too far ahead of the other; compared up to frame {}\n",
                      IdText(entry->key), FrameName(entry->key), id.same);
    }
  }
  if (diff.frames_beyond() > 0) {
    differences += fmt::format("{} frames have ids beyond the first {} and are not compared\n",
                               diff.frames_beyond(), IdTable<IdDiff>::kMost);
  }
  if (const LogDiff::Entry* const entry = FirstToPart(diff)) {
    differences +=
        fmt::format("they part first with {} {}\n", IdText(entry->key), FrameName(entry->key));
  }
  return text + "\n" + (differences.empty() ? "the same frames, id by id\n" : differences);
}

}  // namespace

int CanlogDiff(const CanlogOptions& options) {
  if (options.files.size() != 2) {
    return Refuse(fmt::format("diff: {} files given; it takes two", options.files.size()));
  }
  std::array<CanlogInput, 2> inputs;
  for (std::size_t i = 0; i < 2; ++i) {
    CanlogOptions one = options;
    one.files = {options.files[i]};
    if (const std::string error = inputs[i].Open(one); !error.empty()) {
      return Refuse(error);
    }
  }
  LogDiff diff;
  for (int open = 2; open > 0;) {
    const int which = diff.Behind();
    const auto frames = inputs[static_cast<std::size_t>(which)].log().Next();
    diff.Add(which, frames);
    if (frames.empty()) {
      diff.End(which);
      --open;
    }
  }
  const int whole = std::max(TellProblems(inputs[0].log()), TellProblems(inputs[1].log()));
  if (whole == kCanlogBadInput) {
    return whole;
  }
  const Json json = DiffJson(diff, inputs);
  const int printed = Print(options.json ? Dump(json) : DiffText(diff, options));
  return std::max({whole, printed, json["same"].get<bool>() ? kCanlogOk : kCanlogFailed});
}

}  // namespace pipewright::hil
