// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstdint>
#include <span>

/// Numbers as UFACTORY's controller has them on its wires: integers big-endian, FP32 little-endian
/// (ufactory_docs, communication_protocol/p05communication-format.md). No bounds are checked here.
namespace pipewright::hil::wire_bytes {

using Bytes = std::span<const std::uint8_t>;
using Room = std::span<std::uint8_t>;

/// `count` bytes at `at`, the high one first.
inline std::uint64_t Integer(Bytes bytes, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    value = value << 8 | bytes[at + i];
  }
  return value;
}

inline float Float(Bytes bytes, std::size_t at) {
  std::uint32_t bits = 0;
  for (std::size_t i = 4; i > 0; --i) {
    bits = bits << 8 | bytes[at + i - 1];
  }
  return std::bit_cast<float>(bits);
}

inline void PutInteger(Room room, std::size_t at, std::size_t count, std::uint64_t value) {
  for (std::size_t i = count; i > 0; --i) {
    room[at + i - 1] = static_cast<std::uint8_t>(value & 0xFF);
    value >>= 8;
  }
}

inline void PutFloat(Room room, std::size_t at, double value) {
  auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  for (std::size_t i = 0; i < 4; ++i) {
    room[at + i] = static_cast<std::uint8_t>(bits & 0xFF);
    bits >>= 8;
  }
}

}  // namespace pipewright::hil::wire_bytes
