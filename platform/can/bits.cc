// SPDX-License-Identifier: MIT
#include "platform/can/bits.h"

#include <cstdint>

namespace pipewright::can {
namespace {

constexpr int kStuffAfter = 5;
constexpr std::uint32_t kCrcPolynomial = 0x4599;  // x^15+x^14+x^10+x^8+x^7+x^4+x^3+1
constexpr int kCrcBits = 15;
/// Checksum delimiter, acknowledge slot and delimiter, end of frame, interframe space: not stuffed.
constexpr int kTailBits = 1 + 2 + 7 + 3;

/// The stuffed part of a frame, bit by bit.
class BitStream {
 public:
  void Put(std::uint32_t value, int bits) {
    for (int i = bits - 1; i >= 0; --i) {
      const std::uint32_t bit = (value >> i) & 1;
      crc_ = ((crc_ << 1) & 0x7FFF) ^ ((((crc_ >> 14) & 1) ^ bit) != 0 ? kCrcPolynomial : 0);
      Count(bit);
    }
  }
  void PutChecksum() {
    for (int i = kCrcBits - 1; i >= 0; --i) {
      Count((crc_ >> i) & 1);
    }
  }
  int count() const { return count_; }

 private:
  void Count(std::uint32_t bit) {
    run_ = bit == last_ ? run_ + 1 : 1;
    last_ = bit;
    ++count_;
    if (run_ == kStuffAfter) {
      ++count_;
      last_ = 1 - bit;
      run_ = 1;
    }
  }

  std::uint32_t crc_ = 0;
  std::uint32_t last_ = 2;  // neither bit
  int run_ = 0;
  int count_ = 0;
};

}  // namespace

int FrameBits(const Frame& frame) {
  BitStream bits;
  const std::uint32_t remote = frame.remote ? 1 : 0;
  bits.Put(0, 1);  // start of frame
  if (frame.extended) {
    bits.Put(frame.id >> 18, 11);
    bits.Put(3, 2);  // SRR, IDE
    bits.Put(frame.id & 0x3FFFF, 18);
    bits.Put(remote, 1);
    bits.Put(0, 2);  // r1, r0
  } else {
    bits.Put(frame.id, 11);
    bits.Put(remote, 1);
    bits.Put(0, 2);  // IDE, r0
  }
  bits.Put(frame.dlc, 4);
  for (int i = 0; i < frame.dlc && !frame.remote; ++i) {
    bits.Put(frame.data[i], 8);
  }
  bits.PutChecksum();
  return bits.count() + kTailBits;
}

}  // namespace pipewright::can
