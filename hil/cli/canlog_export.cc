// SPDX-License-Identifier: MIT
#include "hil/cli/canlog_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

#include "hil/canlog/frame_sorter.h"
#include "hil/cli/canlog_mcap.h"
#include "hil/cli/canlog_signals.h"
#include "hil/cli/text_out.h"

namespace pipewright::hil {
namespace {

using Columns = std::array<int, kMostSignals>;  ///< of a row's signals; -1: not wanted

/// The columns of the table. An id that is met on several channels has columns for each of them,
/// which begin with the channel's name.
class Layout {
 public:
  explicit Layout(const CanlogOptions& options) : signals_(options) {}

  const std::string& error() const { return signals_.error(); }

  void Meet(const LogFrame& frame) {
    if (RowOf(frame) >= 0) {
      met_[frame.id].try_emplace(frame.channel);
    }
  }
  /// Without having met any frame: all signals, on whatever channel.
  void MeetAll() {
    all_ = true;
    ForEachSignal([this](const SignalPlace& place) { met_[place.id()].try_emplace(0); });
  }

  /// To be called once, when all frames have been met. @returns the table's head
  std::string Head(const ChannelNames& channels) {
    std::string head = "t_s";
    ForEachSignal([&](const SignalPlace& place) {
      for (auto& [channel, columns] : met_[place.id()]) {
        columns[place.index] = -1;
        if (!signals_.Wants(place.id(), place.index)) {
          continue;
        }
        const bool several = met_[place.id()].size() > 1;
        std::string name = several ? fmt::format("{}/", channels.Name(channel)) : "";
        name += SignalPath(*place.head, place.node, place.name);
        name += place.unit == "1" ? "" : fmt::format(" [{}]", place.unit);
        head += fmt::format(",{}", CsvCell(name));
        columns[place.index] = count_++;
      }
    });
    return head + "\n";
  }
  int count() const { return count_; }

  const Columns* Find(const LogFrame& frame) const {
    const std::map<std::uint8_t, Columns>& by_channel = met_[frame.id];
    const auto found = by_channel.find(all_ ? std::uint8_t{0} : frame.channel);
    return found == by_channel.end() ? nullptr : &found->second;
  }

 private:
  SignalChoice signals_;
  std::array<std::map<std::uint8_t, Columns>, kRowOfId.size()> met_;  ///< by 11-bit id
  bool all_ = false;
  int count_ = 0;
};

/// The row that is being filled, and how rows become lines.
class Table {
 public:
  Table(const Layout& layout, double every_s)
      : layout_(layout),
        every_ns_(std::llround(1e9 * every_s)),
        cells_(static_cast<std::size_t>(layout.count())) {}

  void Head(const std::string& head) { out_.Put(head); }

  void Take(const LogFrame& frame) {
    DecodedFrame decoded;
    const Columns* const columns = RowOf(frame) < 0 ? nullptr : layout_.Find(frame);
    if (columns == nullptr || DecodeFrame(frame, decoded) != Status::kOk ||
        std::none_of(columns->begin(), columns->begin() + decoded.signals.size(),
                     [](int column) { return column >= 0; })) {
      return;
    }
    if (every_ns_ > 0) {
      PassTime(frame.stamp_ns);
    } else {
      NextRow(frame.stamp_ns);
    }
    for (int i = 0; i < decoded.signals.size(); ++i) {
      const int column = (*columns)[static_cast<std::size_t>(i)];
      if (column >= 0) {
        cells_[static_cast<std::size_t>(column)] = decoded.signals[i].value;
      }
    }
  }

  bool End() {
    if (begun_) {
      WriteRow();
    }
    return out_.Flush();
  }
  bool writes() const { return writes_; }

 private:
  /// A row a time: what was not sent then stays empty.
  void NextRow(std::int64_t ns) {
    if (begun_ && ns != row_ns_) {
      WriteRow();
      std::fill(cells_.begin(), cells_.end(), std::nullopt);
    }
    begun_ = true;
    row_ns_ = ns;
  }
  /// A row every so often, with what was sent last before it.
  void PassTime(std::int64_t ns) {
    row_ns_ = begun_ ? row_ns_ : ns;
    begun_ = true;
    for (int rows = 0; ns > row_ns_ && writes_; ++rows) {
      if (rows == kMostHeld) {  // a silence this long is one of the clock
        row_ns_ += (ns - row_ns_) / every_ns_ * every_ns_;
      }
      WriteRow();
      row_ns_ += every_ns_;
    }
  }
  void WriteRow() {
    out_.Put(StampText(row_ns_));
    for (const std::optional<double>& cell : cells_) {
      out_.Put(",");
      if (cell) {
        AppendValue(out_.buffer(), *cell);
      }
    }
    out_.Put("\n");
    writes_ = out_.Continue();
  }

  static constexpr int kMostHeld = 1'000'000;

  const Layout& layout_;
  std::int64_t every_ns_;
  std::vector<std::optional<double>> cells_;
  TextOut out_;
  std::int64_t row_ns_ = 0;
  bool begun_ = false;
  bool writes_ = true;
};

/// Whether the files can be read twice: once for what is in them, once for the table.
bool CanReadTwice(const CanlogOptions& options) {
  return std::all_of(options.files.begin(), options.files.end(), [](const std::string& path) {
    std::error_code failed;
    return path != "-" && std::filesystem::is_regular_file(path, failed);
  });
}

/// The first of two passes. @returns an error in words, or nothing
std::string MeetFrames(const CanlogOptions& options, CanlogInput& input, Layout& layout) {
  if (std::string error = input.Open(options); !error.empty()) {
    return error;
  }
  LogSet& log = input.log();
  for (auto frames = log.Next(); !frames.empty(); frames = log.Next()) {
    for (const LogFrame& frame : frames) {
      layout.Meet(frame);
    }
  }
  return log.error();
}

}  // namespace

int CanlogExport(LogSet& log, const CanlogOptions& options) {
  if (!options.mcap.empty()) {
    return CanlogMcap(log, options);
  }
  const auto layout = std::make_unique<Layout>(options);
  CanlogInput first_pass;
  std::string error = layout->error();
  if (error.empty() && CanReadTwice(options)) {
    error = MeetFrames(options, first_pass, *layout);
  } else {
    layout->MeetAll();
  }
  if (!error.empty()) {
    return Refuse(error);
  }
  const std::string head = layout->Head(first_pass.log().channels());
  Table table(*layout, options.every_s);
  table.Head(head);
  FrameSorter sorter;
  std::uint64_t without_time = 0;
  const auto take = [&table](const LogFrame& frame) { table.Take(frame); };
  for (auto frames = log.Next(); table.writes() && !frames.empty(); frames = log.Next()) {
    for (const LogFrame& frame : frames) {
      if (frame.stamped) {
        sorter.Add(frame, take);
      } else {
        ++without_time;
      }
    }
  }
  sorter.End(take);
  const bool written = table.End();
  if (without_time > 0) {
    fmt::print(stderr, "pipewright: {} frames have no time and are left out\n", without_time);
  }
  return std::max(TellProblems(log), written ? kCanlogOk : OutputFailed());
}

}  // namespace pipewright::hil
