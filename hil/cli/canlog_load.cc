// SPDX-License-Identifier: MIT
#include "hil/cli/canlog_load.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "hil/canlog/load_windows.h"
#include "hil/cli/canlog_signals.h"
#include "hil/cli/text_out.h"
#include "platform/can/tracer.h"

namespace pipewright::hil {
namespace {

struct ChannelPeak {
  std::uint64_t windows = 0;
  double peak = 0;
  std::int64_t at_ns = 0;
};

class Printer {
 public:
  Printer(const LogSet& log, const CanlogOptions& options)
      : log_(log),
        options_(options),
        bitrate_(options.bitrate > 0 ? options.bitrate : can::kTracerBitrate) {
    if (options_.json) {
      out_.Print("{{\"bitrate\":{:.0f},\"window_s\":{:.9g},\"windows\":[", bitrate_,
                 options_.window_s);
    } else if (options_.csv) {
      out_.Put("t_s,channel,frames,load_percent\n");
    } else {
      out_.Print("windows of {:g} s at {:.0f} bit/s{}\n\n{:>20}  {:<8} {:>8} {:>8}\n",
                 options_.window_s, bitrate_,
                 options_.bitrate > 0 ? "" : ", the base's: --bitrate says otherwise", "t s",
                 "channel", "frames", "load %");
    }
  }

  void Print(const WindowLoad& window) {
    const double load = static_cast<double>(window.bits) / (bitrate_ * options_.window_s);
    ChannelPeak& peak = peaks_[window.channel];
    if (load >= peak.peak) {
      peak.peak = load;
      peak.at_ns = window.begin_ns;
    }
    const std::string_view channel = log_.channels().Name(window.channel);
    ++peak.windows;
    if (options_.json) {
      out_.Print("{}{{\"t_s\":{},\"channel\":{},\"frames\":{},\"load\":{:.6f}}}", first_ ? "" : ",",
                 StampText(window.begin_ns), JsonText(channel), window.frames, load);
    } else if (options_.csv) {
      out_.Print("{},{},{},{:.4f}\n", StampText(window.begin_ns), CsvCell(channel), window.frames,
                 100 * load);
    } else {
      out_.Print("{:>20}  {:<8} {:>8} {:>8.2f}  {}\n", StampText(window.begin_ns), channel,
                 window.frames, 100 * load,
                 std::string(static_cast<std::size_t>(std::clamp(50 * load, 0.0, 50.0)), '#'));
    }
    first_ = false;
    writes_ = out_.Continue();
  }

  bool End(const LoadWindows& windows) {
    if (options_.json) {
      EndJson(windows);
    } else if (!options_.csv) {
      out_.Put("\n");
      for (std::size_t i = 0; i < peaks_.size(); ++i) {
        if (peaks_[i].windows > 0) {
          out_.Print("{:<8} peak {:.2f} % at {}\n", log_.channels().Name(static_cast<int>(i)),
                     100 * peaks_[i].peak, StampText(peaks_[i].at_ns));
        }
      }
      if (windows.left_out() > 0) {
        out_.Print("load leaves out {} frames of CAN FD\n", windows.left_out());
      }
    }
    return out_.Flush();
  }

  bool writes() const { return writes_; }

 private:
  void EndJson(const LoadWindows& windows) {
    out_.Put("],\"peaks\":[");
    const char* before = "";
    for (std::size_t i = 0; i < peaks_.size(); ++i) {
      if (peaks_[i].windows > 0) {
        out_.Print("{}{{\"channel\":{},\"load\":{:.6f},\"t_s\":{}}}", before,
                   JsonText(log_.channels().Name(static_cast<int>(i))), peaks_[i].peak,
                   StampText(peaks_[i].at_ns));
        before = ",";
      }
    }
    out_.Print("],\"fd_left_out\":{},\"files\":{}}}\n", windows.left_out(), FilesJsonText(log_));
  }

  const LogSet& log_;
  const CanlogOptions& options_;
  double bitrate_;
  TextOut out_;
  std::array<ChannelPeak, 256> peaks_{};
  bool first_ = true;
  bool writes_ = true;
};

}  // namespace

int CanlogLoad(LogSet& log, const CanlogOptions& options) {
  Printer printer(log, options);
  LoadWindows windows(std::llround(1e9 * options.window_s),
                      [&printer](const WindowLoad& window) { printer.Print(window); });
  for (auto frames = log.Next(); printer.writes() && !frames.empty(); frames = log.Next()) {
    windows.Add(frames);
  }
  if (!log.error().empty()) {
    return TellProblems(log);
  }
  windows.End();
  const bool written = printer.End(windows);
  return std::max(TellProblems(log), written ? kCanlogOk : OutputFailed());
}

}  // namespace pipewright::hil
