// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <tuple>

#include "platform/can/codec.h"

/// What can be said of a whole table, a std::tuple of FrameSpec: that it is well formed (checked
/// where it is declared, by static_assert), and which row a received frame belongs to.
namespace pipewright::can {

/// Frames taken, and frames refused by reason.
struct RxCounters {
  std::uint64_t accepted = 0;
  std::uint64_t error_frame = 0;
  std::uint64_t extended = 0;
  std::uint64_t remote = 0;
  std::uint64_t unknown_id = 0;
  std::uint64_t wrong_length = 0;
  std::uint64_t out_of_range = 0;
};

namespace table_internal {

template <typename Msg>
constexpr bool Fits(const Signal<Msg>& s, const FrameHead& head) {
  using codec_internal::Round;
  if (s.bits < 1 || s.bits > 32 || s.start < 0 || s.start + s.bits > 8 * head.dlc ||
      !(s.scale > 0) || !(s.min <= s.max) ||
      (s.field.is_code && (s.sign == Sign::kSigned || s.scale != 1))) {
    return false;
  }
  const bool whole_bytes = s.start % 8 == 0 && s.bits % 8 == 0;
  const bool inside_a_byte = s.start / 8 == (s.start + s.bits - 1) / 8;
  if (head.order == ByteOrder::kBigEndian && !whole_bytes && !inside_a_byte) {
    return false;
  }
  const std::int64_t span = std::int64_t{1} << s.bits;
  const std::int64_t lowest = s.sign == Sign::kSigned ? -span / 2 : 0;
  return lowest <= Round(s.min / s.scale) && Round(s.max / s.scale) < lowest + span;
}

constexpr bool Collide(const FrameHead& a, const FrameHead& b) {
  const std::uint32_t a_first = a.id + (a.max_node > 0 ? 1 : 0);
  const std::uint32_t b_first = b.id + (b.max_node > 0 ? 1 : 0);
  return a_first <= b.id + static_cast<std::uint32_t>(b.max_node) &&
         b_first <= a.id + static_cast<std::uint32_t>(a.max_node);
}

}  // namespace table_internal

/// Every signal fits its bits, its limits and the payload; no two signals share a bit.
template <typename Msg, std::size_t k>
constexpr bool WellFormed(const FrameSpec<Msg, k>& spec) {
  const FrameHead& head = spec.head;
  if (head.dlc < 0 || head.dlc > 8 || head.also_dlc < 0 || head.also_dlc > 8 || head.max_node < 0 ||
      head.id + static_cast<std::uint32_t>(head.max_node) > 0x7FF) {
    return false;
  }
  std::uint64_t taken = 0;
  for (const Signal<Msg>& s : spec.signals) {
    if (!table_internal::Fits(s, head)) {
      return false;
    }
    const std::uint64_t bits = codec_internal::Mask(s.bits) << s.start;
    if ((taken & bits) != 0) {
      return false;
    }
    taken |= bits;
  }
  return true;
}

template <typename... Row, typename F>
constexpr void ForEachRow(const std::tuple<Row...>& table, F&& f) {
  std::apply([&](const auto&... row) { (f(row), ...); }, table);
}

/// Every row is well formed, and no two rows claim one id.
template <typename... Row>
constexpr bool WellFormed(const std::tuple<Row...>& table) {
  bool good = true;
  ForEachRow(table, [&](const auto& row) {
    int claims = 0;
    ForEachRow(table, [&](const auto& other) {
      claims += table_internal::Collide(row.head, other.head) ? 1 : 0;
    });
    good = good && WellFormed(row) && claims == 1;
  });
  return good;
}

/// Decodes `frame` by its row and calls visit(head, message, node); counts it either way.
///
/// Status as Decode, kMalformed too when no row claims the id. At most one comparison a row.
template <typename... Row, typename Visit>
constexpr Status Dispatch(const std::tuple<Row...>& table, const Frame& frame, RxCounters& counters,
                          Visit&& visit) {
  const auto refuse = [](std::uint64_t& counter, Status why) {
    ++counter;
    return why;
  };
  if (frame.error) {
    return refuse(counters.error_frame, Status::kMalformed);
  }
  if (frame.extended) {
    return refuse(counters.extended, Status::kMalformed);
  }
  if (frame.remote) {
    return refuse(counters.remote, Status::kMalformed);
  }
  Status status = Status::kMalformed;
  bool known = false;
  const auto try_row = [&](const auto& row) {
    const int node = NodeOf(row.head, frame.id);
    if (known || node < 0) {
      return;
    }
    known = true;
    const auto msg = Decode(row, frame);
    status = msg.status();
    if (msg.ok()) {
      ++counters.accepted;
      visit(row.head, *msg, node);
    } else {
      ++(status == Status::kOutOfRange ? counters.out_of_range : counters.wrong_length);
    }
  };
  ForEachRow(table, try_row);
  return known ? status : refuse(counters.unknown_id, Status::kMalformed);
}

}  // namespace pipewright::can
