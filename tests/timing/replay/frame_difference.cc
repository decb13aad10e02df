// SPDX-License-Identifier: MIT
#include "tests/timing/replay/frame_difference.h"

#include <algorithm>
#include <cmath>

#include "platform/can/cia402.h"
#include "platform/can/tracer.h"

namespace pipewright::timing {
namespace {

template <typename Spec>
bool SameUnclaimed(const Spec& spec, const can::Frame& a, const can::Frame& b) {
  std::uint64_t claimed = 0;
  for (const auto& signal : spec.signals) {
    claimed |= can::codec_internal::Mask(signal.bits) << signal.start;
  }
  for (int i = 0; i < a.dlc; ++i) {
    const auto free = static_cast<unsigned>(~(claimed >> (8 * i)) & 0xFF);
    if (((a.data[i] ^ b.data[i]) & free) != 0) {
      return false;
    }
  }
  return true;
}

template <typename Spec>
std::optional<std::int64_t> Difference(const Spec& spec, const can::Frame& a, const can::Frame& b) {
  const auto from = can::Decode(spec, a);
  const auto to = can::Decode(spec, b);
  if (!from.ok() || !to.ok() || !SameUnclaimed(spec, a, b)) {
    return std::nullopt;
  }
  std::int64_t largest = 0;
  for (const auto& signal : spec.signals) {
    const std::int64_t lsb =
        std::llround((signal.field.Get(*to) - signal.field.Get(*from)) / signal.scale);
    if (signal.field.is_code && lsb != 0) {
      return std::nullopt;
    }
    largest = std::max(largest, lsb < 0 ? -lsb : lsb);
  }
  return largest;
}

template <typename Table>
std::optional<std::int64_t> DifferenceIn(const Table& table, const can::Frame& a,
                                         const can::Frame& b) {
  std::optional<std::int64_t> difference;
  can::ForEachRow(table, [&](const auto& row) {
    if (can::NodeOf(row.head, a.id) >= 0) {
      difference = Difference(row, a, b);
    }
  });
  return difference;
}

}  // namespace

std::optional<std::int64_t> LsbDifference(BusName bus, const can::Frame& a, const can::Frame& b) {
  if (a == b) {
    return 0;
  }
  if (a.id != b.id || a.dlc != b.dlc) {
    return std::nullopt;
  }
  return bus == BusName::kBase ? DifferenceIn(can::kTracerTable, a, b)
                               : DifferenceIn(can::kArmTable, a, b);
}

}  // namespace pipewright::timing
