// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>

#include "platform/can/frame.h"
#include "platform/core/status.h"

/// The text log of can-utils' `candump -L`, one frame a line:
///
///   (1795305881.460729) can0 111#01F4000000000000       11-bit id
///   (1795305881.460729) can0 1ABCDEF0#                  29-bit id, no payload
///   (1795305881.460729) can0 123#R4                     remote, length 4
///   (1795305881.460729) can0 20000040#0000000000000000  error frame: id with bit 29 set
namespace pipewright::can {

/// Longest line that FormatCandump writes, newline included.
inline constexpr int kCandumpLineBytes = 80;
inline constexpr int kInterfaceNameBytes = 15;

/// Writes one line, ended by '\n', and returns its length. Microseconds, cut off. No trailing
/// direction mark: other readers take it for a broken file.
///
/// kFull: `out` is too short. kMalformed: the name is empty, longer than 15 bytes or has a space.
Result<int> FormatCandump(const Frame& frame, std::string_view interface, std::span<char> out);

struct CandumpLine {
  Frame frame;                 ///< stamp as in the log
  std::string_view interface;  ///< points into the line that was parsed
};

/// Reads one line: 6 or 9 decimals, either case of hex digits, anything after the frame.
/// kMalformed: anything else, and CAN FD (`##`).
Result<CandumpLine> ParseCandump(std::string_view line);

/// Walks over a log held in memory. Lines that do not begin with '(' are skipped, as canplayer
/// does.
///
///   CandumpReader reader(text);
///   for (Result<CandumpLine> r = reader.Next(); ; r = reader.Next()) {
///     if (r.status() == Status::kUnavailable) break;   // the end
///     if (!r.ok()) return Complain(reader.line());     // its number; reading may go on
///     Use(r->frame);
///   }
class CandumpReader {
 public:
  explicit CandumpReader(std::string_view text) : rest_(text) {}

  /// kUnavailable: no line is left. kMalformed: line() is not understood.
  Result<CandumpLine> Next();
  /// Number of the line that Next() read last, from 1.
  int line() const { return line_; }

 private:
  std::string_view rest_;
  int line_ = 0;
};

}  // namespace pipewright::can
