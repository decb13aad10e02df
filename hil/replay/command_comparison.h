// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "hil/canlog/id_table.h"
#include "hil/canlog/log_frame.h"
#include "platform/can/frame.h"
#include "platform/core/time.h"

namespace pipewright::hil {

/// Whether the robot sends a frame like this: commands, requests, and its own heartbeat. All else
/// it receives.
bool IsCommand(const LogFrame& frame);

/// Where a recording and its replay part. A side that has no such frame has no value; the recorded
/// frame's stamp is the wire's, the replayed one's that of the control cycle that sent it.
struct CommandDifference {
  std::optional<LogFrame> recorded;
  std::optional<LogFrame> replayed;

  Time at() const { return Time(Duration((recorded ? *recorded : *replayed).stamp_ns)); }
};

/// What recording and replay have of one id.
struct CommandCounts {
  std::uint64_t same = 0;
  std::uint64_t different = 0;
  std::uint64_t not_replayed = 0;  ///< recorded only
  std::uint64_t not_recorded = 0;  ///< replayed only

  bool differs() const { return different + not_replayed + not_recorded > 0; }
};

/// Compares the commands of a replay with those that were recorded, id by id, as time goes on. A
/// frame that was recorded is the oldest of its id that had been sent by then and has not been met
/// with yet; if it differs from that, but equals the next, the recording lacks one.
///
/// When the recording ends, what was sent shortly before may still be waiting for the wire: it is
/// left out, unless its device got a later command, since commands to a device keep their order.
class CommandComparison {
 public:
  /// Longer than any frame waits for the wire.
  static constexpr Duration kLongestWait = std::chrono::milliseconds(100);

  using Entry = IdTable<CommandCounts>::Entry;

  /// The replay's control cycle at `now` sends a frame.
  void Replayed(const can::Frame& frame, Time now);
  /// The next frame of the recording that is a command, after all that was replayed before its
  /// stamp.
  void Recorded(const LogFrame& frame);
  /// The recording goes no further than `end`.
  void End(Time end);

  std::uint64_t same() const { return total_.same; }
  std::uint64_t differences() const {
    return total_.different + total_.not_replayed + total_.not_recorded;
  }
  const CommandCounts& total() const { return total_; }
  /// The earliest difference.
  const std::optional<CommandDifference>& first() const { return first_; }
  /// By id.
  std::vector<const Entry*> Sorted() const;

 private:
  struct Sent {
    LogFrame frame;
    std::uint64_t number;  ///< among those to the same device
  };
  struct Waiting {
    IdKey key;
    std::deque<Sent> frames;
  };

  CommandCounts& CountsOf(const IdKey& key);
  std::deque<Sent>& WaitingOf(const IdKey& key);
  void Meet(const LogFrame& recorded, const Sent& sent);
  void NotRecorded(const IdKey& key, const LogFrame& frame);
  void Differ(const CommandDifference& difference);

  IdTable<CommandCounts> counts_;
  std::vector<Waiting> waiting_;
  std::array<std::uint64_t, 2> sent_{};  ///< to the base and to the arm
  std::array<std::uint64_t, 2> met_{};   ///< of these, the last that was recorded
  CommandCounts total_;
  std::optional<CommandDifference> first_;
};

}  // namespace pipewright::hil
