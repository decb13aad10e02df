// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "hil/canlog/frame_sorter.h"
#include "hil/canlog/log_set.h"
#include "hil/devices/port.h"
#include "hil/replay/command_comparison.h"

namespace pipewright::hil {

/// A CAN log as the robot's wire: gives what the devices sent, each frame from its stamp on, and
/// compares what the robot sends with what it sent then. Base and arm may share it, since no id
/// means two things; whatever channels the log has, they are one here.
///
/// Time counts from the log's own zero, which is a run's start; of a log whose stamps are those of
/// a calendar, from its first frame.
///
///   RecordedBus bus(path);
///   if (const std::string error = bus.Open(); !error.empty()) return Fail(error);
///   for (bus.AdvanceTo(now); !bus.AtEnd(); bus.AdvanceTo(now += 1ms)) Step(bus, now);
class RecordedBus final : public Port {
 public:
  /// A log that is silent for so long has ended: what comes then has a stamp that is wrong.
  static constexpr Duration kLongestSilence = std::chrono::seconds(10);
  /// Stamps from then on, a year, count from no run's start.
  static constexpr Time kCalendar{std::chrono::hours(24 * 365)};

  /// @param path  of a log in any format that LogReader knows; "-": standard input
  explicit RecordedBus(const std::string& path) : log_({path}, {.whole_lines = true}, {}) {}

  /// @returns why the log cannot be replayed at all, in words, or nothing
  std::string Open();
  /// Reads what is left, for log() to know all that is wrong with it.
  void ReadToEnd();

  /// What was on the wire up to `now`.
  void AdvanceTo(Time now);
  /// Whether no frame is later than that. Only before its end the log tells all that was heard.
  bool AtEnd() { return !HasNext(); }

  /// The robot sends at the time of the last AdvanceTo. Never full.
  Status Send(const can::Frame& frame) override;
  bool Receive(can::Frame& frame) override;

  const LogSet& log() const { return log_; }
  CommandComparison& comparison() { return comparison_; }
  const CommandComparison& comparison() const { return comparison_; }
  std::uint64_t states() const { return states_; }      ///< frames given to the robot
  std::uint64_t commands() const { return commands_; }  ///< frames that the robot had sent
  /// Frames that no robot of ours takes: CAN FD, or without a time, or a time before another's
  /// that was on the wire long since.
  std::uint64_t passed_over() const { return passed_over_; }
  /// Frames behind a silence that ended the log; 0: none did. Known after ReadToEnd().
  std::uint64_t beyond_silence() const { return beyond_silence_; }

 private:
  /// Whether next_ is there; else the log has ended.
  bool HasNext();
  void Read();

  LogSet log_;
  FrameSorter sorter_;
  std::deque<LogFrame> sorted_;
  std::optional<LogFrame> next_;  ///< by the replay's time
  bool read_all_ = false;
  bool begun_ = false;
  bool ended_ = false;
  std::int64_t zero_ns_ = 0;
  std::int64_t last_ns_ = 0;  ///< of the frame before next_
  Time now_{};
  std::deque<can::Frame> heard_;
  CommandComparison comparison_;
  std::uint64_t states_ = 0;
  std::uint64_t commands_ = 0;
  std::uint64_t passed_over_ = 0;
  std::uint64_t beyond_silence_ = 0;
};

}  // namespace pipewright::hil
