// SPDX-License-Identifier: MIT
#include "hil/faults/wire_bits.h"

#include <algorithm>
#include <vector>

namespace pipewright::hil {
namespace {

constexpr int kCrcBits = 15;
constexpr int kHeadBits = 19;  // start of frame to length code

/// x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1, one bit at a time as the standard has it.
std::uint32_t Checksum(std::span<const bool> bits) {
  std::uint32_t crc = 0;
  for (const bool bit : bits) {
    const bool next = bit != ((crc & 0x4000U) != 0);
    crc = (crc << 1) & 0x7FFFU;
    crc ^= next ? 0x4599U : 0U;
  }
  return crc;
}

struct Bits {
  void Put(std::uint32_t value, int count) {
    for (int i = count - 1; i >= 0; --i) {
      bits[size++] = ((value >> i) & 1) != 0;
    }
  }
  std::uint32_t Get(int begin, int count) const {
    std::uint32_t value = 0;
    for (int i = begin; i < begin + count; ++i) {
      value = value << 1 | (bits[i] ? 1U : 0U);
    }
    return value;
  }
  bool bits[kHeadBits + 64 + kCrcBits] = {};
  int size = 0;
};

}  // namespace

std::optional<can::Frame> ReceiveFlipped(const can::Frame& frame, std::span<const int> flipped) {
  Bits wire;
  wire.Put(0, 1);
  wire.Put(frame.id, 11);
  wire.Put(0, 3);  // RTR, IDE, r0
  wire.Put(frame.dlc, 4);
  for (int i = 0; i < frame.dlc; ++i) {
    wire.Put(frame.data[static_cast<std::size_t>(i)], 8);
  }
  wire.Put(Checksum({wire.bits, static_cast<std::size_t>(wire.size)}), kCrcBits);
  for (const int bit : flipped) {
    wire.bits[bit] = !wire.bits[bit];
  }
  if (wire.Get(0, 1) != 0 || wire.Get(13, 1) != 0) {
    return std::nullopt;  // no start, or the head of another format: the rest does not fit it
  }
  can::Frame read{.id = wire.Get(1, 11), .stamp = frame.stamp};
  read.remote = wire.Get(12, 1) != 0;
  read.dlc = static_cast<std::uint8_t>(std::min(wire.Get(15, 4), 8U));
  const int payload = read.remote ? 0 : read.dlc;
  const int covered = kHeadBits + 8 * payload;
  if (covered + kCrcBits > wire.size ||
      wire.Get(covered, kCrcBits) != Checksum({wire.bits, static_cast<std::size_t>(covered)})) {
    return std::nullopt;
  }
  for (int i = 0; i < payload; ++i) {
    read.data[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(wire.Get(kHeadBits + 8 * i, 8));
  }
  return read;
}

}  // namespace pipewright::hil
