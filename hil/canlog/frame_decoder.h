// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "hil/canlog/code_names.h"
#include "hil/canlog/frame_rows.h"
#include "hil/canlog/log_frame.h"
#include "platform/core/fixed_vector.h"
#include "platform/core/status.h"

namespace pipewright::hil {

/// One signal of a frame, as its row of the tables says.
struct SignalValue {
  std::string_view name;
  std::string_view unit;  ///< "1": none
  double value = 0;
  AppendCode append_name = nullptr;  ///< writes what a code means; null: a quantity

  bool has_name() const { return append_name != nullptr; }
};

inline constexpr int kMostSignals = 10;  ///< of a row

struct DecodedFrame {
  const can::FrameHead* head = nullptr;
  int node = 0;  ///< 0: the row has none
  FixedVector<SignalValue, kMostSignals> signals;
};

/// Decodes by the tables of platform/can, those of the base and of the arm alike.
///
/// kUnavailable: no row has the id. kMalformed: the row has another length, or no remote frame.
/// kOutOfRange: a signal is outside the row's limits. Either way `head` and `node` are set.
Status DecodeFrame(const LogFrame& frame, DecodedFrame& to);

/// "base_state/battery", "tpdo1_joint_feedback/3/position".
std::string SignalPath(const can::FrameHead& head, int node, std::string_view signal);

/// Whether `pattern` means the signal: one without '/' names its frame or the signal itself, one
/// with '/' its whole path. '*' stands for any characters.
bool MeansSignal(std::string_view pattern, const can::FrameHead& head, int node,
                 std::string_view signal);

/// Where a signal stands in the tables.
struct SignalPlace {
  const can::FrameHead* head = nullptr;
  int node = 0;
  std::size_t index = 0;  ///< in its row
  std::string_view name;
  std::string_view unit;

  std::uint32_t id() const { return head->id + static_cast<std::uint32_t>(node); }
};

/// Calls visit(place) for each signal of each node of the tables.
template <typename Visit>
void ForEachSignal(Visit&& visit) {
  can::ForEachRow(kLogTable, [&visit](const auto& row) {
    for (int node = row.head.max_node > 0 ? 1 : 0; node <= row.head.max_node; ++node) {
      for (std::size_t i = 0; i < row.signals.size(); ++i) {
        visit(SignalPlace{&row.head, node, i, row.signals[i].name, row.signals[i].unit});
      }
    }
  });
}

}  // namespace pipewright::hil
