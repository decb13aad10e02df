// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "hil/canlog/id_table.h"
#include "hil/canlog/log_frame.h"
#include "hil/canlog/log_stats.h"

namespace pipewright::hil {

/// Where two logs part, for one id: frame `index` of that id, counted from 0. A log that has no
/// such frame has no value.
struct FirstDifference {
  std::uint64_t index = 0;
  std::array<std::optional<LogFrame>, 2> frames;
};

/// What two logs have of one id.
struct IdDiff {
  std::array<std::uint64_t, 2> frames{};
  std::optional<FirstDifference> first;
  std::uint64_t same = 0;  ///< frames until they part
  bool given_up = false;   ///< one log was too far ahead: what follows is not compared
  PeriodStats later;       ///< by how much the second has a frame later, each from its own
                           ///< log's first frame; up to where they part

  bool differs() const { return first.has_value() || frames[0] != frames[1]; }

  std::deque<LogFrame> pending;  ///< of the log that is ahead
  int ahead = 0;
};

/// Compares two logs id by id: the frames of each id in their order, whatever the order between ids
/// and on whatever channel. Both are read side by side; frames of the log that is ahead wait, at
/// most kMostPending of them, so that memory is bounded.
class LogDiff {
 public:
  static constexpr std::size_t kMostPending = 200'000;

  using Entry = IdTable<IdDiff>::Entry;

  /// Frames of log `which`, 0 or 1.
  void Add(int which, std::span<const LogFrame> frames);
  /// Log `which` has no more.
  void End(int which);
  /// Which log is to be read on, so that neither gets ahead: that with less time since its first
  /// frame, or, without times, with fewer frames.
  int Behind() const;

  /// By id: 11-bit ids, 29-bit ids, error messages. To be called when both have ended.
  std::vector<const Entry*> Sorted() const;
  std::uint64_t frames_beyond() const { return beyond_; }  ///< of ids for which there was no room

 private:
  struct Side {
    bool begun = false;
    bool ended = false;
    std::int64_t first_ns = 0;
    std::int64_t since_ns = 0;  ///< of the last frame, since the first
    std::uint64_t frames = 0;
  };

  void Take(int which, const LogFrame& frame, IdDiff& id);
  void Compare(const LogFrame& first, const LogFrame& second, IdDiff& id);
  std::int64_t Since(int which, const LogFrame& frame) const;

  std::array<Side, 2> sides_;
  IdTable<IdDiff> ids_;
  std::size_t pending_ = 0;
  std::uint64_t beyond_ = 0;
};

}  // namespace pipewright::hil
