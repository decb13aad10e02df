// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <tuple>

#include "hil/canlog/log_frame.h"
#include "platform/can/cia402.h"
#include "platform/can/tracer.h"

/// The tables of platform/can as a log needs them: both devices at once, since a log may hold the
/// one, the other, or both of a shared bus.
namespace pipewright::hil {

inline constexpr auto kLogTable = std::tuple_cat(can::kTracerTable, can::kArmTable);
static_assert(can::WellFormed(kLogTable), "no id means two things on a shared bus");

inline constexpr auto kLogHeads =
    std::apply([](const auto&... row) { return std::array{row.head...}; }, kLogTable);

/// The row of an 11-bit id, as an index into kLogHeads; -1: none has it.
inline constexpr std::array<std::int8_t, 2048> kRowOfId = [] {
  std::array<std::int8_t, 2048> row_of{};
  row_of.fill(-1);
  for (std::size_t row = 0; row < kLogHeads.size(); ++row) {
    const can::FrameHead& head = kLogHeads[row];
    for (int node = head.max_node > 0 ? 1 : 0; node <= head.max_node; ++node) {
      row_of[head.id + static_cast<std::uint32_t>(node)] = static_cast<std::int8_t>(row);
    }
  }
  return row_of;
}();

/// The row that names a frame; -1: none. Error messages and 29-bit ids are in no table.
constexpr int RowOf(std::uint32_t id, bool extended, bool error) {
  return extended || error || id >= kRowOfId.size() ? -1 : kRowOfId[id];
}
constexpr int RowOf(const LogFrame& frame) {
  return frame.fd ? -1 : RowOf(frame.id, frame.extended, frame.error);
}

}  // namespace pipewright::hil
