// SPDX-License-Identifier: MIT
#include "hil/faults/wire_bits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "platform/core/rng.h"

namespace pipewright::hil {
namespace {

can::Frame AnyFrame(Rng& rng) {
  can::Frame frame{.id = static_cast<std::uint32_t>(rng.Index(0x800)),
                   .dlc = static_cast<std::uint8_t>(rng.Index(9))};
  for (int i = 0; i < frame.dlc; ++i) {
    frame.data[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(rng.Index(256));
  }
  return frame;
}

TEST(ReceiveFlipped, WithoutAnErrorHandsTheFrameOn) {
  Rng rng(1);
  for (int i = 0; i < 1000; ++i) {
    const can::Frame frame = AnyFrame(rng);
    const auto read = ReceiveFlipped(frame, {});
    ASSERT_TRUE(read);
    EXPECT_EQ(*read, frame);
  }
}

/// The polynomial has a Hamming distance of 6 at this length [Bosch, CAN Specification 2.0, 1991]:
/// up to five errors are found wherever they are, but for those in the length code, which move the
/// checksum itself.
TEST(ReceiveFlipped, FindsUpToFiveErrorsOutsideTheLengthCode) {
  Rng rng(2);
  for (int i = 0; i < 100'000; ++i) {
    const can::Frame frame = AnyFrame(rng);
    std::vector<int> at;
    const int count = 1 + rng.Index(5);
    while (static_cast<int>(at.size()) < count) {
      const int bit = rng.Index(WireBits(frame));
      if ((bit < 12 || bit > 18) && std::find(at.begin(), at.end(), bit) == at.end()) {
        at.push_back(bit);
      }
    }
    ASSERT_FALSE(ReceiveFlipped(frame, at)) << "frame " << i;
  }
}

/// Errors that are themselves a multiple of the polynomial pass: flipping its 16 bits in a row.
TEST(ReceiveFlipped, LetsAMultipleOfThePolynomialPass) {
  const can::Frame frame{.id = 0x123, .dlc = 4, .data = {1, 2, 3, 4}};
  std::vector<int> at;
  constexpr int kFirst = 24;  // in the payload
  for (int i = 0; i <= 15; ++i) {
    if (((0x8000U | 0x4599U) >> (15 - i) & 1) != 0) {
      at.push_back(kFirst + i);
    }
  }
  const auto read = ReceiveFlipped(frame, at);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->id, frame.id);
  EXPECT_NE(read->data, frame.data);
}

}  // namespace
}  // namespace pipewright::hil
