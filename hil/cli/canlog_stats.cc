// SPDX-License-Identifier: MIT
#include "hil/cli/canlog_stats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMsPerS = 1e3;

Json OrNull(std::optional<double> value) { return value ? Json(*value) : Json(nullptr); }

/// @param channel  that of the frames; null: those of several
Json StatsJson(const FrameStats& s, const FrameStats* channel, const CanlogOptions& options) {
  const bool timed = s.stamped > 0;
  const bool periodic = s.periods.count() > 0;
  Json json = {
      {"frames", s.frames},
      {"remote", s.remote},
      {"fd", s.fd},
      {"errors", s.errors},
      {"payload_bytes", s.payload_bytes},
      {"rate_hz", OrNull(s.rate_hz())},
      {"period_s", periodic ? Json({{"min", s.periods.min_s()},
                                    {"mean", s.periods.mean_s()},
                                    {"max", s.periods.max_s()},
                                    {"jitter", s.periods.deviation_s()}})
                            : Json(nullptr)},
      {"first_s", timed ? Json(1e-9 * static_cast<double>(s.first_ns)) : Json(nullptr)},
      {"last_s", timed ? Json(1e-9 * static_cast<double>(s.last_ns)) : Json(nullptr)},
      {"backward", s.backward},
  };
  if (options.bitrate > 0) {
    json["bits"] = s.bits;
    json["load"] = channel != nullptr ? OrNull(s.load(options.bitrate, *channel)) : Json(nullptr);
  }
  return json;
}

Json AllJson(const LogSet& log, const LogStats& stats, const CanlogOptions& options) {
  Json channels = Json::array();
  for (std::size_t i = 0; i < stats.channels().size(); ++i) {
    if (stats.channels()[i].frames > 0) {
      Json channel = {{"channel", log.channels().Name(static_cast<int>(i))}};
      channel.update(StatsJson(stats.channels()[i], &stats.channels()[i], options));
      channels.push_back(std::move(channel));
    }
  }
  Json ids = Json::array();
  for (const auto& [id, its] : stats.Sorted()) {
    Json one = {
        {"channel", log.channels().Name(id.channel)}, {"id", IdText(id)}, {"name", FrameName(id)}};
    one.update(StatsJson(its, &stats.channels()[id.channel], options));
    ids.push_back(std::move(one));
  }
  return {{"files", FilesJson(log)},
          {"bitrate", options.bitrate > 0 ? Json(options.bitrate) : Json(nullptr)},
          {"all", StatsJson(stats.all(), nullptr, options)},
          {"channels", channels},
          {"ids", ids},
          {"frames_beyond_ids", stats.frames_beyond()}};
}

std::string Cell(std::optional<double> value, int width, int decimals) {
  return value ? fmt::format("{:{}.{}f}", *value, width, decimals)
               : fmt::format("{:>{}}", "-", width);
}

std::string Figures(const FrameStats& s, const FrameStats* channel, std::int64_t origin_ns,
                    const CanlogOptions& options) {
  const auto of_periods = [&s](double value_s) {
    return s.periods.count() > 0 ? std::optional(kMsPerS * value_s) : std::nullopt;
  };
  const auto since_origin = [&s, origin_ns](std::int64_t ns) {
    return s.stamped > 0 ? std::optional(1e-9 * static_cast<double>(ns - origin_ns)) : std::nullopt;
  };
  std::string line = fmt::format(
      "{:>10} {} {} {} {} {} {:>11} {} {}", s.frames, Cell(s.rate_hz(), 9, 2),
      Cell(of_periods(s.periods.min_s()), 10, 3), Cell(of_periods(s.periods.mean_s()), 10, 3),
      Cell(of_periods(s.periods.max_s()), 10, 3), Cell(of_periods(s.periods.deviation_s()), 10, 3),
      s.payload_bytes, Cell(since_origin(s.first_ns), 12, 6), Cell(since_origin(s.last_ns), 12, 6));
  if (options.bitrate > 0) {
    const std::optional<double> load =
        channel != nullptr ? s.load(options.bitrate, *channel) : std::nullopt;
    line += fmt::format(" {}", Cell(load ? std::optional(100 * *load) : std::nullopt, 7, 2));
  }
  return line;
}

std::string Notes(const FrameStats& all, const LogStats& stats, const CanlogOptions& options) {
  std::string text;
  if (all.backward > 0) {
    text += fmt::format("{} stamps are below that of the frame before\n", all.backward);
  }
  if (all.stamped < all.frames) {
    text += fmt::format("{} frames have no time\n", all.frames - all.stamped);
  }
  if (options.bitrate > 0 && all.fd > 0) {
    text += fmt::format("load leaves out {} frames of CAN FD\n", all.fd);
  }
  if (stats.frames_beyond() > 0) {
    text += fmt::format("{} frames have ids beyond the first {}, which are in the sums only\n",
                        stats.frames_beyond(), LogStats::kMostIds);
  }
  return text;
}

std::string Table(const LogSet& log, const LogStats& stats, const CanlogOptions& options) {
  const FrameStats& all = stats.all();
  std::string text = FilesText(log);
  if (all.stamped > 0) {
    text += fmt::format("times in s from {}.{:09}\n", all.first_ns / 1'000'000'000,
                        all.first_ns % 1'000'000'000);
  }
  text += fmt::format(
      "\n{:<8} {:<10} {:<24} {:>10} {:>9} {:>10} {:>10} {:>10} {:>10} {:>11} {:>12} {:>12}{}\n",
      "channel", "id", "frame", "frames", "rate Hz", "min ms", "mean ms", "max ms", "jitter ms",
      "bytes", "first s", "last s", options.bitrate > 0 ? "  load %" : "");
  const auto line = [&](std::string_view channel, const std::string& id, const std::string& name,
                        const FrameStats& s, const FrameStats* of) {
    text += fmt::format("{:<8} {:<10} {:<24} {}\n", channel, id, name,
                        Figures(s, of, all.first_ns, options));
  };
  for (const auto& [id, its] : stats.Sorted()) {
    line(log.channels().Name(id.channel), IdText(id), FrameName(id), its,
         &stats.channels()[id.channel]);
  }
  for (std::size_t i = 0; i < stats.channels().size(); ++i) {
    if (stats.channels()[i].frames > 0) {
      line(log.channels().Name(static_cast<int>(i)), "all", "", stats.channels()[i],
           &stats.channels()[i]);
    }
  }
  line("all", "all", "", all, nullptr);
  return text + Notes(all, stats, options);
}

}  // namespace

int CanlogStats(LogSet& log, const CanlogOptions& options) {
  LogStats stats(options.bitrate > 0);
  for (auto frames = log.Next(); !frames.empty(); frames = log.Next()) {
    stats.Add(frames);
  }
  const int whole = TellProblems(log);
  if (whole == kCanlogBadInput) {
    return whole;
  }
  const int printed =
      Print(options.json ? Dump(AllJson(log, stats, options)) : Table(log, stats, options));
  return std::max(whole, printed);
}

}  // namespace pipewright::hil
