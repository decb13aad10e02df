// SPDX-License-Identifier: MIT
#include "hil/cli/canlog_gaps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "hil/canlog/code_names.h"
#include "hil/canlog/error_message.h"
#include "hil/canlog/log_watch.h"
#include "hil/cli/canlog_signals.h"
#include "hil/cli/text_out.h"
#include "platform/can/sdo.h"

namespace pipewright::hil {
namespace {

std::string ObjectText(const can::Object& object) {
  return fmt::format("{:04X}h:{}", object.index, object.subindex);
}

std::string EmergencyText(const Finding& f) {
  fmt::memory_buffer text;
  AppendEmergency(text, f.code);
  return "EMCY: " + fmt::to_string(text);
}

std::string ErrorText(const Finding& f) {
  fmt::memory_buffer text;
  AppendErrorMessage(text, *f.frame);
  return fmt::to_string(text);
}

/// What was found, in words.
std::string Words(const Finding& f) {
  switch (f.kind) {
    case FindingKind::kGap:
      return fmt::format("silent for {:.6f} s, expected every {:.6f} s", f.seconds, f.expected_s);
    case FindingKind::kDuplicate:
      return fmt::format("the same bytes again after {:.6f} s", f.seconds);
    case FindingKind::kCountJump:
      return fmt::format("the count jumps: {} frames are missing", f.code);
    case FindingKind::kCountRepeat:
      return "the count stands still";
    case FindingKind::kCountBack:
      return fmt::format("the count goes back by {}", f.code);
    case FindingKind::kCommandExpired:
      return fmt::format("no command for {:.6f} s: the base stops by itself after {:g} s{}",
                         f.seconds, ToSeconds(can::kTracerCommandTimeout),
                         f.code != 0 ? "; it was told to move" : "");
    case FindingKind::kHeartbeatLost:
      return fmt::format("no heartbeat for {:.6f} s", f.seconds);
    case FindingKind::kRestart:
      return "the node booted up again";
    case FindingKind::kEmergency:
      return EmergencyText(f);
    case FindingKind::kErrorMessage:
      return ErrorText(f);
    case FindingKind::kSdoUnanswered:
      return fmt::format("SDO {} without an answer for {:.6f} s{}", ObjectText(f.object), f.seconds,
                         f.code != 0 ? "; nothing was ever heard of the node" : "");
    case FindingKind::kSdoAborted:
      return fmt::format("SDO {} aborted, code 0x{:08X}", ObjectText(f.object), f.code);
    case FindingKind::kTimeBack:
      return fmt::format("its time is {:.6f} s before that of the frame before", f.seconds);
    case FindingKind::kSdoBeforeBoot:
      return fmt::format("note: SDO {} asked again after {:.6f} s, the node was not heard of yet",
                         ObjectText(f.object), f.seconds);
  }
  return "";
}

class Printer {
 public:
  Printer(const LogSet& log, const CanlogOptions& options) : log_(log), options_(options) {
    if (options_.json) {
      out_.Put("{\"findings\":[");
    }
  }

  void Print(const Finding& f) {
    if (counts_[static_cast<std::size_t>(f.kind)]++ >= options_.most) {
      return;
    }
    const std::string_view channel = log_.channels().Name(f.key.channel);
    if (options_.json) {
      out_.Print(
          "{}{{\"kind\":\"{}\",\"t_s\":{},\"channel\":{},\"id\":\"{}\",\"name\":\"{}\","
          "\"seconds\":{:.9f},\"what\":\"{}\"}}",
          first_ ? "" : ",", Name(f.kind), StampText(f.at_ns), JsonText(channel), IdText(f.key),
          FrameName(f.key), f.seconds, Words(f));
    } else {
      out_.Print("{}  {:<6}  {:<8}  {:<24} {:<15}  {}\n", StampText(f.at_ns), channel,
                 IdText(f.key), FrameName(f.key), Name(f.kind), Words(f));
    }
    first_ = false;
    writes_ = out_.Continue();
  }

  bool End(const LogWatch& watch) {
    out_.Put(options_.json ? "],\"counts\":{" : first_ ? "" : "\n");
    for (int kind = 0; kind < kFindingKinds; ++kind) {
      const std::uint64_t count = counts_[static_cast<std::size_t>(kind)];
      const char* const name = Name(static_cast<FindingKind>(kind));
      if (options_.json) {
        out_.Print("{}\"{}\":{}", kind == 0 ? "" : ",", name, count);
      } else if (count > 0) {
        out_.Print(
            "{:<15} {:>10}{}{}\n", name, count,
            IsNote(static_cast<FindingKind>(kind)) ? ", a note and no fault" : "",
            count > options_.most ? fmt::format(", the first {} are printed", options_.most) : "");
      }
    }
    if (options_.json) {
      out_.Print("}},\"frames_beyond_ids\":{},\"files\":{}}}\n", watch.not_watched(),
                 FilesJsonText(log_));
    } else if (faults() == 0) {
      out_.Put(first_ ? "nothing found\n" : "no fault found\n");
    }
    return out_.Flush();
  }

  bool writes() const { return writes_; }
  std::uint64_t faults() const {
    std::uint64_t faults = 0;
    for (int kind = 0; kind < kFindingKinds; ++kind) {
      const bool note = IsNote(static_cast<FindingKind>(kind));
      faults += note ? 0 : counts_[static_cast<std::size_t>(kind)];
    }
    return faults;
  }

 private:
  const LogSet& log_;
  const CanlogOptions& options_;
  TextOut out_;
  std::array<std::uint64_t, kFindingKinds> counts_{};
  bool first_ = true;
  bool writes_ = true;
};

}  // namespace

int CanlogGaps(LogSet& log, const CanlogOptions& options) {
  Printer printer(log, options);
  LogWatch watch({.gap_factor = options.gap_factor},
                 [&printer](const Finding& finding) { printer.Print(finding); });
  for (auto frames = log.Next(); printer.writes() && !frames.empty(); frames = log.Next()) {
    watch.Add(frames);
  }
  if (!log.error().empty()) {
    return TellProblems(log);
  }
  watch.End();
  const bool written = printer.End(watch);
  const int whole = TellProblems(log);
  return std::max({whole, written ? kCanlogOk : OutputFailed(),
                   printer.faults() > 0 ? kCanlogFailed : kCanlogOk});
}

}  // namespace pipewright::hil
