// SPDX-License-Identifier: MIT
#include "hil/cli/canlog_decode.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "hil/canlog/error_message.h"
#include "hil/canlog/frame_decoder.h"
#include "hil/cli/canlog_signals.h"
#include "hil/cli/text_out.h"

namespace pipewright::hil {
namespace {

struct DecodeCounts {
  std::uint64_t decoded = 0;
  std::uint64_t no_row = 0;
  std::uint64_t wrong_length = 0;
  std::uint64_t out_of_range = 0;
};

/// Why a frame that has a row has no signals, in words.
const char* Why(Status status) {
  return status == Status::kOutOfRange ? "a signal is outside its limits" : "wrong length";
}

class Writer {
 public:
  Writer(const LogSet& log, const CanlogOptions& options)
      : log_(log), options_(options), signals_(options), modes_(ControlModesNamed(options.modes)) {}

  void Begin() {
    if (options_.csv) {
      out_.Put("t_s,channel,id,frame,node,signal,value,unit,name\n");
    } else if (options_.json) {
      out_.Put("{\"frames\":[");
    }
  }

  /// False: standard output takes no more.
  bool Frame(const LogFrame& frame) {
    DecodedFrame decoded;
    const Status status = DecodeFrame(frame, decoded);
    if (!frame.error) {
      Count(status);
    }
    if (status == Status::kOk) {
      signals_.Keep(frame.id, decoded);
      if (decoded.signals.empty() && signals_.chosen()) {
        return true;
      }
    } else if (signals_.chosen() || (status == Status::kUnavailable && !frame.error)) {
      return true;
    }
    if (options_.csv) {
      Csv(frame, decoded);
    } else if (options_.json) {
      Json(frame, decoded, status);
    } else {
      Text(frame, decoded, status);
    }
    return out_.Continue();
  }

  bool End() {
    if (options_.json) {
      out_.Print(
          "],\"counts\":{{\"decoded\":{},\"no_row\":{},\"wrong_length\":{},\"out_of_range\":"
          "{}}},\"files\":{}}}\n",
          counts_.decoded, counts_.no_row, counts_.wrong_length, counts_.out_of_range,
          FilesJsonText(log_));
    }
    return out_.Flush();
  }

  const DecodeCounts& counts() const { return counts_; }

 private:
  void Count(Status status) {
    ++(status == Status::kOk            ? counts_.decoded
       : status == Status::kUnavailable ? counts_.no_row
       : status == Status::kOutOfRange  ? counts_.out_of_range
                                        : counts_.wrong_length);
  }

  void AppendName(const SignalValue& signal) {
    signal.append_name(out_.buffer(), static_cast<std::uint32_t>(signal.value), modes_);
  }

  void Text(const LogFrame& frame, const DecodedFrame& decoded, Status status) {
    out_.Put(frame.stamped ? StampText(frame.stamp_ns) : "");
    out_.Print("  {:<6}  {}  ", log_.channels().Name(frame.channel), IdText(KeyOf(frame)));
    if (frame.error) {
      AppendErrorMessage(out_.buffer(), frame);
      out_.Put("\n");
      return;
    }
    const std::size_t begin = out_.buffer().size();
    out_.Put(decoded.head->name);
    if (decoded.node > 0) {
      out_.Print(" {}", decoded.node);
    }
    constexpr std::size_t kNameWidth = 24;
    const std::size_t written = out_.buffer().size() - begin;
    if (!decoded.signals.empty() || status != Status::kOk) {
      out_.Print("{:{}}", "", written < kNameWidth ? kNameWidth - written : 1);
    }
    if (status != Status::kOk) {
      out_.Print("? {} bytes: {}", frame.length, Why(status));
    }
    for (const SignalValue& signal : decoded.signals) {
      out_.Print(" {}=", signal.name);
      if (signal.has_name()) {
        AppendName(signal);
      } else {
        AppendValue(out_.buffer(), signal.value);
        out_.Put(signal.unit == "1" ? "" : " ");
        out_.Put(signal.unit == "1" ? "" : signal.unit);
      }
      out_.Put(&signal == decoded.signals.end() - 1 ? "" : ";");
    }
    out_.Put("\n");
  }

  void CsvHead(const LogFrame& frame) {
    out_.Put(frame.stamped ? StampText(frame.stamp_ns) : "");
    out_.Print(",{},{},", CsvCell(log_.channels().Name(frame.channel)), IdText(KeyOf(frame)));
  }

  void Csv(const LogFrame& frame, const DecodedFrame& decoded) {
    if (frame.error) {
      CsvHead(frame);
      out_.Put("error,0,class,");
      out_.Print("{},,\"", frame.id);
      AppendErrorMessage(out_.buffer(), frame);
      out_.Put("\"\n");
      return;
    }
    for (const SignalValue& signal : decoded.signals) {
      CsvHead(frame);
      out_.Print("{},{},{},", decoded.head->name, decoded.node, signal.name);
      AppendValue(out_.buffer(), signal.value);
      out_.Print(",{},", signal.unit == "1" ? "" : signal.unit);
      if (signal.has_name()) {
        out_.Put("\"");
        AppendName(signal);
        out_.Put("\"");
      }
      out_.Put("\n");
    }
  }

  void Json(const LogFrame& frame, const DecodedFrame& decoded, Status status) {
    out_.Put(first_ ? "{\"t_s\":" : ",{\"t_s\":");
    first_ = false;
    out_.Put(frame.stamped ? StampText(frame.stamp_ns) : "null");
    out_.Print(",\"channel\":{},\"id\":\"{}\"", JsonText(log_.channels().Name(frame.channel)),
               IdText(KeyOf(frame)));
    if (frame.error) {
      out_.Put(",\"error\":\"");
      AppendErrorMessage(out_.buffer(), frame);
      out_.Put("\"}");
      return;
    }
    out_.Print(",\"frame\":\"{}\"", decoded.head->name);
    if (decoded.node > 0) {
      out_.Print(",\"node\":{}", decoded.node);
    }
    if (status != Status::kOk) {
      out_.Print(",\"wrong\":\"{}\"}}", Why(status));
      return;
    }
    out_.Put(",\"signals\":{");
    for (const SignalValue& signal : decoded.signals) {
      out_.Print("{}\"{}\":", &signal == decoded.signals.begin() ? "" : ",", signal.name);
      if (signal.has_name()) {
        out_.Put("\"");
        AppendName(signal);
        out_.Put("\"");
      } else {
        AppendValue(out_.buffer(), signal.value);
      }
    }
    out_.Put("}}");
  }

  const LogSet& log_;
  const CanlogOptions& options_;
  SignalChoice signals_;
  const ControlModes& modes_;
  TextOut out_;
  DecodeCounts counts_;
  bool first_ = true;
};

}  // namespace

int CanlogDecode(LogSet& log, const CanlogOptions& options) {
  if (const std::string error = SignalChoice(options).error(); !error.empty()) {
    return Refuse(error);
  }
  Writer writer(log, options);
  writer.Begin();
  bool writes = true;
  for (auto frames = log.Next(); writes && !frames.empty(); frames = log.Next()) {
    for (const LogFrame& frame : frames) {
      writes = writes && writer.Frame(frame);
    }
  }
  writes = writer.End() && writes;
  const int whole = TellProblems(log);
  const DecodeCounts& counts = writer.counts();
  if (!options.json && counts.no_row + counts.wrong_length + counts.out_of_range > 0) {
    fmt::print(stderr,
               "pipewright: frames decoded: {}; with an id that is neither the base's nor the "
               "arm's: {}; with the wrong length: {}; with a signal outside its limits: {}\n",
               counts.decoded, counts.no_row, counts.wrong_length, counts.out_of_range);
  }
  return std::max(whole, writes ? kCanlogOk : OutputFailed());
}

}  // namespace pipewright::hil
