// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hil/canlog/log_frame.h"

namespace pipewright::hil {

/// Chooses frames by id and time.
///
///   ids    hex, several apart by commas: 211, a range 180-1FF, a mask 180/780 (id/mask), or
///   `error`
///          for error messages. Up to 3 digits mean 11-bit ids, more mean 29-bit ones.
///   times  seconds from the log's first frame, or of the log's own clock behind an @
///
/// No ids: all frames. Frames without a time are in no span of time.
class FrameFilter {
 public:
  /// @returns an error in words, or nothing
  std::string AddIds(std::string_view text);
  std::string SetFrom(const std::string& text) { return SetTime(text, "--from", from_); }
  std::string SetTo(const std::string& text) { return SetTime(text, "--to", to_); }

  bool keeps_all() const { return !by_id_ && !from_.set && !to_.set; }
  /// Moves the frames that are wanted to the front. @returns how many
  std::size_t Keep(std::span<LogFrame> frames);

 private:
  struct Bound {
    bool set = false;
    bool absolute = false;
    std::int64_t ns = 0;
  };
  /// Ids in first..last that equal `first` where `mask` has ones.
  struct Rule {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    std::uint32_t mask = 0;
    std::uint32_t value = 0;

    bool Wants(std::uint32_t id) const { return first <= id && id <= last && (id & mask) == value; }
  };

  static std::string SetTime(const std::string& text, const char* option, Bound& bound);
  std::string AddOne(std::string_view text);
  void Add(const Rule& rule, bool extended);
  bool WantsId(const LogFrame& frame) const;
  bool WantsTime(const LogFrame& frame) const;

  bool by_id_ = false;
  bool errors_ = false;
  std::bitset<2048> short_ids_;
  std::vector<Rule> long_ids_;
  Bound from_;
  Bound to_;
  bool begun_ = false;
  std::int64_t first_ns_ = 0;
};

}  // namespace pipewright::hil
