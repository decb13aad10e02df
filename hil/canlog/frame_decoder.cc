// SPDX-License-Identifier: MIT
#include "hil/canlog/frame_decoder.h"

#include <fmt/format.h>

#include <algorithm>

namespace pipewright::hil {
namespace {

constexpr std::size_t kRows = std::tuple_size_v<decltype(kLogTable)>;

/// Looked up once, not for each frame.
template <std::size_t kRow>
const auto kNamesOfRow = [] {
  const auto& row = std::get<kRow>(kLogTable);
  std::array<AppendCode, kMostSignals> names{};
  for (std::size_t i = 0; i < row.signals.size(); ++i) {
    names[i] = NamesOf(row.head.name, row.signals[i].name);
  }
  return names;
}();

template <std::size_t kRow>
Status DecodeRow(const can::Frame& frame, DecodedFrame& to) {
  const auto& row = std::get<kRow>(kLogTable);
  static_assert(row.signals.size() <= kMostSignals);
  const auto message = can::Decode(row, frame);
  if (!message.ok()) {
    return message.status();
  }
  std::size_t i = 0;
  for (const auto& signal : row.signals) {
    static_cast<void>(
        to.signals.push_back({signal.name, signal.unit, signal.field.Get(*message),
                              signal.field.is_code ? kNamesOfRow<kRow>[i] : nullptr}));
    ++i;
  }
  return Status::kOk;
}

using Decoder = Status (*)(const can::Frame&, DecodedFrame&);

constexpr auto kDecoders = []<std::size_t... kRow>(std::index_sequence<kRow...>) {
  return std::array<Decoder, kRows>{DecodeRow<kRow>...};
}
(std::make_index_sequence<kRows>());

/// `pattern` with '*' for any characters; linear in both, by going back to the last '*' only.
bool Matches(std::string_view pattern, std::string_view text) {
  std::size_t p = 0;
  std::size_t t = 0;
  std::size_t star = std::string_view::npos;
  std::size_t after_star = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      after_star = t;
    } else if (p < pattern.size() && pattern[p] == text[t]) {
      ++p;
      ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++after_star;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

}  // namespace

Status DecodeFrame(const LogFrame& frame, DecodedFrame& to) {
  const int row = RowOf(frame);
  if (row < 0) {
    return Status::kUnavailable;
  }
  to.head = &kLogHeads[static_cast<std::size_t>(row)];
  to.node = can::NodeOf(*to.head, frame.id);
  to.signals = {};
  return kDecoders[static_cast<std::size_t>(row)](ClassicFrame(frame), to);
}

std::string SignalPath(const can::FrameHead& head, int node, std::string_view signal) {
  return node > 0 ? fmt::format("{}/{}/{}", head.name, node, signal)
                  : fmt::format("{}/{}", head.name, signal);
}

bool MeansSignal(std::string_view pattern, const can::FrameHead& head, int node,
                 std::string_view signal) {
  if (pattern.find('/') == std::string_view::npos) {
    return Matches(pattern, head.name) || Matches(pattern, signal);
  }
  return Matches(pattern, SignalPath(head, node, signal));
}

}  // namespace pipewright::hil
