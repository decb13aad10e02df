// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "hil/canlog/error_message.h"
#include "hil/canlog/frame_decoder.h"
#include "hil/canlog/log_reader.h"
#include "hil/canlog/log_stats.h"
#include "hil/canlog/log_watch.h"
#include "tests/fuzz/require.h"

namespace pipewright::test {

/// Does with a frame what `canlog decode` does.
inline void DecodeInWords(const hil::LogFrame& frame) {
  fmt::memory_buffer words;
  if (frame.error) {
    hil::AppendErrorMessage(words, frame);
    return;
  }
  hil::DecodedFrame decoded;
  if (hil::DecodeFrame(frame, decoded) != Status::kOk) {
    return;
  }
  for (const hil::SignalValue& signal : decoded.signals) {
    if (signal.has_name()) {
      signal.append_name(words, static_cast<std::uint32_t>(signal.value), can::kModesSdk);
    }
  }
}

/// Does with a log what all of `canlog` does with one. What a reader gives must be frames.
inline void ReadWholeLog(const std::uint8_t* bytes, std::size_t size, bool deltas) {
  if (size == 0) {
    return;  // fmemopen has no empty file
  }
  hil::ChannelNames channels;
  hil::LogReader reader(channels);
  std::FILE* const file = fmemopen(const_cast<std::uint8_t*>(bytes), size, "rb");
  if (!reader.Open(file, "input", {.deltas = deltas}).empty()) {
    return;
  }
  std::optional<hil::LogStats> stats;
  std::optional<hil::LogWatch> watch;
  if (size % 4 == 0) {  // their tables take longer to make than most inputs to read
    stats.emplace(/*count_bits=*/true);
    watch.emplace(hil::WatchConfig(), [](const hil::Finding& finding) {
      Require(hil::Name(finding.kind) != nullptr, "a finding has a name");
    });
  }
  for (auto frames = reader.Next(); !frames.empty(); frames = reader.Next()) {
    for (const hil::LogFrame& frame : frames) {
      Require(frame.channel < channels.size(), "a frame's channel has a name");
      Require(frame.id < (frame.extended || frame.error ? 1U << 29 : 1U << 11),
              "an id has 11 bits, or 29");
      Require(frame.length <= (frame.fd ? 64 : 8), "a payload has a length that CAN has");
      Require(!frame.stamped || frame.stamp_ns >= 0, "a stamp is not before 1970");
      DecodeInWords(frame);
    }
    if (stats) {
      stats->Add(frames);
      watch->Add(frames);
    }
  }
  if (stats) {
    watch->End();
    static_cast<void>(stats->Sorted());
  }
}

}  // namespace pipewright::test
