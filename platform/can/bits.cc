// SPDX-License-Identifier: MIT
#include "platform/can/bits.h"

#include <array>
#include <cstdint>

namespace pipewright::can {
namespace {

constexpr int kStuffAfter = 5;
constexpr std::uint32_t kCrcPolynomial = 0x4599;  // x^15+x^14+x^10+x^8+x^7+x^4+x^3+1
constexpr std::uint32_t kCrcMask = 0x7FFF;
constexpr int kCrcBits = 15;
/// Checksum delimiter, acknowledge slot and delimiter, end of frame, interframe space: not stuffed.
constexpr int kTailBits = 1 + 2 + 7 + 3;

/// What the bits so far say of the next: the last of them, and how many equal ones it ends, 1 to 4.
/// At the fifth a bit of the other kind is put in, which is then the last, and the first of its
/// run.
constexpr int kRuns = kStuffAfter - 1;
constexpr int kStates = 2 * kRuns;
constexpr int kAfterStart = 0;  // start of frame: one 0

constexpr int State(int last, int run) { return last * kRuns + run - 1; }

/// The state after a bit, and how many bits were put in.
struct Stuffed {
  std::uint8_t state;
  std::uint8_t inserted;
};

constexpr Stuffed PutBit(int state, int bit) {
  const int last = state / kRuns;
  const int run = bit == last ? state % kRuns + 2 : 1;
  if (run == kStuffAfter) {
    return {static_cast<std::uint8_t>(State(1 - bit, 1)), 1};
  }
  return {static_cast<std::uint8_t>(State(bit, run)), 0};
}

constexpr auto kStuffedByte = [] {
  std::array<std::array<Stuffed, 256>, kStates> table{};
  for (int state = 0; state < kStates; ++state) {
    for (int byte = 0; byte < 256; ++byte) {
      Stuffed& entry = table[static_cast<std::size_t>(state)][static_cast<std::size_t>(byte)];
      entry.state = static_cast<std::uint8_t>(state);
      for (int i = 7; i >= 0; --i) {
        const Stuffed step = PutBit(entry.state, (byte >> i) & 1);
        entry.state = step.state;
        entry.inserted = static_cast<std::uint8_t>(entry.inserted + step.inserted);
      }
    }
  }
  return table;
}();

constexpr auto kCrcOfByte = [] {
  std::array<std::uint16_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte << (kCrcBits - 8);
    for (int i = 0; i < 8; ++i) {
      crc = ((crc << 1) & kCrcMask) ^ (((crc >> (kCrcBits - 1)) & 1) != 0 ? kCrcPolynomial : 0);
    }
    table[byte] = static_cast<std::uint16_t>(crc);
  }
  return table;
}();

/// The stuffed part of a frame after its start, from the front.
class BitStream {
 public:
  void PutByte(std::uint32_t byte) {
    crc_ = ((crc_ << 8) & kCrcMask) ^ kCrcOfByte[((crc_ >> (kCrcBits - 8)) ^ byte) & 0xFF];
    Count(byte);
  }
  /// Fewer than 8 bits, in front of all bytes: there a checksum is not moved by zeros before them.
  void PutFirst(std::uint32_t value, int bits) {
    crc_ = kCrcOfByte[value];
    CountBits(value, bits);
  }
  void PutChecksum() {
    const std::uint32_t crc = crc_;
    CountBits(crc >> 8, kCrcBits - 8);
    Count(crc & 0xFF);
  }
  int inserted() const { return inserted_; }

 private:
  void Count(std::uint32_t byte) {
    const Stuffed& step = kStuffedByte[static_cast<std::size_t>(state_)][byte];
    state_ = step.state;
    inserted_ += step.inserted;
  }
  void CountBits(std::uint32_t value, int bits) {
    for (int i = bits - 1; i >= 0; --i) {
      const Stuffed step = PutBit(state_, static_cast<int>((value >> i) & 1));
      state_ = step.state;
      inserted_ += step.inserted;
    }
  }

  std::uint32_t crc_ = 0;
  int state_ = kAfterStart;
  int inserted_ = 0;
};

}  // namespace

int FrameBits(const Frame& frame) {
  // Identifier to length code, as one number: 18 bits, or 38 of a frame with a 29-bit id.
  const std::uint64_t remote = frame.remote ? 1 : 0;
  const std::uint64_t head =
      frame.extended ? std::uint64_t{frame.id >> 18 & 0x7FF} << 27 | std::uint64_t{3} << 25 |
                           std::uint64_t{frame.id & 0x3FFFF} << 7 | remote << 6 | (frame.dlc & 0xFU)
                     : std::uint64_t{frame.id & 0x7FF} << 7 | remote << 6 | (frame.dlc & 0xFU);
  const int head_bits = frame.extended ? 38 : 18;
  BitStream bits;
  int left = head_bits / 8 * 8;
  bits.PutFirst(static_cast<std::uint32_t>(head >> left), head_bits - left);
  while (left > 0) {
    left -= 8;
    bits.PutByte(static_cast<std::uint32_t>(head >> left) & 0xFF);
  }
  const int payload = frame.remote ? 0 : frame.dlc;
  for (int i = 0; i < payload; ++i) {
    bits.PutByte(frame.data[static_cast<std::size_t>(i)]);
  }
  bits.PutChecksum();
  return 1 + head_bits + 8 * payload + kCrcBits + bits.inserted() + kTailBits;
}

}  // namespace pipewright::can
