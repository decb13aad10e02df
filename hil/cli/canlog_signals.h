// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <array>
#include <bitset>
#include <string>
#include <string_view>

#include "hil/canlog/frame_decoder.h"
#include "hil/cli/canlog_input.h"

namespace pipewright::hil {

/// Which signals --signal asks for; all when it is not given.
class SignalChoice {
 public:
  explicit SignalChoice(const CanlogOptions& options);

  /// That a pattern means no signal at all, in words; empty if each means some.
  const std::string& error() const { return error_; }
  bool chosen() const { return chosen_; }
  /// Whether the signal with this index in its row is wanted of the frames with this 11-bit id.
  bool Wants(std::uint32_t id, std::size_t signal) const { return wanted_[id][signal]; }
  /// Takes the signals out that are not wanted.
  void Keep(std::uint32_t id, DecodedFrame& frame) const;

 private:
  void Want(const std::string& pattern);

  bool chosen_;
  std::array<std::bitset<kMostSignals>, kRowOfId.size()> wanted_{};  ///< by 11-bit id
  std::string error_;
};

/// The control modes that --modes names.
const ControlModes& ControlModesNamed(std::string_view name);

/// As many digits as 32 bits on the wire have, and no more: 25.9, not 25.900000000000002.
void AppendValue(fmt::memory_buffer& to, double value);
/// A channel's name as a cell of CSV, and as text of JSON.
std::string CsvCell(std::string_view text);
std::string JsonText(std::string_view text);

}  // namespace pipewright::hil
