// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hil/canlog/id_table.h"
#include "hil/canlog/log_set.h"

namespace pipewright::hil {

/// What all of `pipewright canlog` can be asked.
struct CanlogOptions {
  std::vector<std::string> files;
  std::vector<std::string> ids;
  std::string from;
  std::string to;
  bool deltas = false;
  bool json = false;
  bool csv = false;
  double bitrate = 0;  ///< bit/s; 0: not given
  std::vector<std::string> signals;
  double gap_factor = 3;
  std::uint64_t most = 100;  ///< lines of each kind of finding
  double window_s = 1;
  double every_s = 0;         ///< 0: a row whenever something was sent
  std::string modes = "sdk";  ///< ControlModesNamed
  std::string mcap;           ///< the file that `export` is to write; empty: CSV instead
  std::string depth;          ///< the depth frames that it has besides; empty: none
  int points_every = 2;       ///< of these: every so many-th pixel each way
  std::string device;         ///< of a DBC file: "tracer", "uf7"; empty: both
};

/// The frames of the files that are wanted, with a progress bar on standard error where that is a
/// terminal and the files' sizes are known.
class CanlogInput {
 public:
  /// @returns an error in words, or nothing
  std::string Open(const CanlogOptions& options);
  LogSet& log() { return *log_; }
  const LogSet& log() const { return *log_; }

 private:
  std::unique_ptr<LogSet> log_ = std::make_unique<LogSet>();
};

/// Exit codes of the command.
inline constexpr int kCanlogOk = 0;
inline constexpr int kCanlogFailed = 1;
inline constexpr int kCanlogBadInput = 2;

/// Says on standard error what of the log could not be read. @returns the exit code for that
int TellProblems(const LogSet& log);

/// "files" of every object: what was read, and what could not be.
nlohmann::ordered_json FilesJson(const LogSet& log);
std::string FilesJsonText(const LogSet& log);
/// One line a file, for people.
std::string FilesText(const LogSet& log);

/// Says why on standard error. @returns the exit code for bad input, for standard output taking no
/// more
int Refuse(const std::string& why);
int OutputFailed();

/// Prints `text`. @returns the exit code: a failure if standard output takes no more
int Print(const std::string& text);
/// A file's or channel's name may be any bytes; JSON takes UTF-8 only.
std::string Dump(const nlohmann::ordered_json& object);

/// An id as people write it: 3 hex digits, 8 of a 29-bit one.
std::string IdText(const IdKey& id);
/// "tpdo1_joint_feedback 3"; empty: neither the base nor the arm has the id.
std::string FrameName(const IdKey& id);
/// "01F4000000000000", "remote 4".
std::string PayloadText(const LogFrame& frame);
/// Seconds of the log's clock: microseconds, or nanoseconds where there are any.
std::string StampText(std::int64_t ns);

}  // namespace pipewright::hil
