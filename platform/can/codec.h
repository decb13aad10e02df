// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "platform/can/frame.h"
#include "platform/core/status.h"

/// The one codec. A frame is a declarative row; encoder, decoder, emulators, docs and tests read
/// the same rows. Nothing here allocates, throws or asserts on what a bus delivers.
namespace pipewright::can {

enum class Sign : std::uint8_t { kUnsigned, kSigned };
enum class ByteOrder : std::uint8_t { kLittleEndian, kBigEndian };
enum class Direction : std::uint8_t { kToDevice, kFromDevice };

/// Where a signal lives in its message: a physical quantity (double), or a code or bit set
/// (std::uint32_t; unsigned on the wire, scale 1).
template <typename Msg>
struct Field {
  double (*Get)(const Msg& msg);
  void (*Set)(Msg& msg, double value);
  bool is_code;
};

namespace codec_internal {

template <typename Msg, typename T, T Msg::*kMember>
constexpr Field<Msg> MakeField() {
  static_assert(std::is_same_v<T, double> || std::is_same_v<T, std::uint32_t>);
  return {[](const Msg& msg) { return static_cast<double>(msg.*kMember); },
          [](Msg& msg, double value) { msg.*kMember = static_cast<T>(value); },
          std::is_same_v<T, std::uint32_t>};
}

template <auto kMember>
struct FieldOf;

template <typename Msg, typename T, T Msg::*kMember>
struct FieldOf<kMember> {
  static constexpr Field<Msg> kValue = MakeField<Msg, T, kMember>();
};

}  // namespace codec_internal

/// kField<&Message::member>, for a table's column.
template <auto kMember>
inline constexpr auto kField = codec_internal::FieldOf<kMember>::kValue;

/// `bits` bits from bit `start` carry round(field / scale), which lies in [min, max] / scale.
///
/// Bit 8 k + j is bit j of byte k, in either byte order. A big-endian signal is shorter than a byte
/// and inside one, or whole bytes with the high byte first, at `start`.
template <typename Msg>
struct Signal {
  std::string_view name;
  std::string_view unit;
  Field<Msg> field;
  int start;
  int bits;  ///< 1 to 32
  Sign sign;
  double scale;  ///< unit per least significant bit
  double min;
  double max;
};

/// What a row says of its frame as a whole.
struct FrameHead {
  std::string_view name;
  std::uint32_t id;  ///< 11 bits; of node n in 1..max_node: id + n
  int max_node;      ///< 0: one frame, at id
  int dlc;           ///< sent
  int also_dlc;      ///< received as well, bits that it lacks as 0; dlc: there is no second form
  Duration period;   ///< nominal; zero: on demand
  ByteOrder order;
  Direction direction;
};

template <typename Msg, std::size_t k>
struct FrameSpec {
  using Message = Msg;
  FrameHead head;
  std::array<Signal<Msg>, k> signals;
};

/// The node that `id` addresses in this row (0 when the row has no nodes), or -1: not this row.
constexpr int NodeOf(const FrameHead& head, std::uint32_t id) {
  if (head.max_node == 0) {
    return id == head.id ? 0 : -1;
  }
  const bool ours = id > head.id && id - head.id <= static_cast<std::uint32_t>(head.max_node);
  return ours ? static_cast<int>(id - head.id) : -1;
}

namespace codec_internal {

constexpr std::uint64_t Mask(int bits) { return (std::uint64_t{1} << bits) - 1; }

/// Nearest integer, halves away from zero; |x| < 2^62.
constexpr std::int64_t Round(double x) {
  return static_cast<std::int64_t>(x < 0 ? x - 0.5 : x + 0.5);
}

/// Reverses the bytes of a big-endian signal; one shorter than two bytes is left as it is.
constexpr std::uint64_t InOrder(std::uint64_t raw, int bits, ByteOrder order) {
  if (order == ByteOrder::kLittleEndian || bits <= 8) {
    return raw;
  }
  std::uint64_t swapped = 0;
  for (int done = 0; done < bits; done += 8) {
    swapped = (swapped << 8) | ((raw >> done) & 0xFF);
  }
  return swapped;
}

}  // namespace codec_internal

/// kOutOfRange: a field is not finite, or its nearest wire value is outside [min, max]; node is
/// outside 1..max_node (outside 0 for a row without nodes).
template <typename Msg, std::size_t k>
constexpr Result<Frame> Encode(const FrameSpec<Msg, k>& spec, const Msg& msg, int node = 0) {
  using namespace codec_internal;
  const FrameHead& head = spec.head;
  if (node < (head.max_node > 0 ? 1 : 0) || node > head.max_node) {
    return Status::kOutOfRange;
  }
  std::uint64_t payload = 0;
  for (const Signal<Msg>& s : spec.signals) {
    const double value = s.field.Get(msg) / s.scale;
    if (!(value > -0x1p40 && value < 0x1p40)) {  // written so that NaN fails too
      return Status::kOutOfRange;
    }
    const std::int64_t raw = Round(value);
    if (raw < Round(s.min / s.scale) || raw > Round(s.max / s.scale)) {
      return Status::kOutOfRange;
    }
    payload |= InOrder(static_cast<std::uint64_t>(raw) & Mask(s.bits), s.bits, head.order)
               << s.start;
  }
  Frame frame{.id = head.id + static_cast<std::uint32_t>(node),
              .dlc = static_cast<std::uint8_t>(head.dlc)};
  for (std::uint8_t& byte : frame.data) {
    byte = static_cast<std::uint8_t>(payload & 0xFF);
    payload >>= 8;
  }
  return frame;
}

/// kMalformed: another id, an extended, remote or error frame, or a wrong length.
/// kOutOfRange: a signal is outside its limits. Bits that no signal claims are not looked at.
template <typename Msg, std::size_t k>
constexpr Result<Msg> Decode(const FrameSpec<Msg, k>& spec, const Frame& frame) {
  using namespace codec_internal;
  const FrameHead& head = spec.head;
  if (frame.extended || frame.remote || frame.error || NodeOf(head, frame.id) < 0 ||
      (frame.dlc != head.dlc && frame.dlc != head.also_dlc)) {
    return Status::kMalformed;
  }
  std::uint64_t payload = 0;
  for (int i = frame.dlc - 1; i >= 0; --i) {
    payload = (payload << 8) | frame.data[static_cast<std::size_t>(i)];
  }
  Msg msg{};
  for (const Signal<Msg>& s : spec.signals) {
    const std::uint64_t bits = InOrder((payload >> s.start) & Mask(s.bits), s.bits, head.order);
    const bool negative = s.sign == Sign::kSigned && ((bits >> (s.bits - 1)) & 1) != 0;
    const std::int64_t raw =
        static_cast<std::int64_t>(bits) - (negative ? std::int64_t{1} << s.bits : 0);
    if (raw < Round(s.min / s.scale) || raw > Round(s.max / s.scale)) {
      return Status::kOutOfRange;
    }
    s.field.Set(msg, static_cast<double>(raw) * s.scale);
  }
  return msg;
}

}  // namespace pipewright::can
