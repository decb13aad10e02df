// SPDX-License-Identifier: MIT
#include "hil/canlog/line_scanner.h"

namespace pipewright::hil {
namespace {

constexpr std::uint32_t kErrorFlag = 0x20000000;
constexpr std::uint32_t kMost11Bits = 0x7FF;
constexpr std::uint32_t kMost29Bits = 0x1FFFFFFF;
constexpr std::uint64_t kMostSeconds = 9'000'000'000;
constexpr std::int64_t kPlaces[] = {1'000'000'000, 100'000'000, 10'000'000, 1'000'000, 100'000,
                                    10'000,        1'000,       100,        10,        1};

}  // namespace

bool LineScanner::Seconds(std::int64_t& ns) {
  std::uint64_t seconds = 0;
  std::uint64_t fraction = 0;
  if (Decimal(10, seconds) == 0 || seconds > kMostSeconds || !Take('.')) {
    return false;
  }
  const int decimals = Decimal(9, fraction);
  ns = static_cast<std::int64_t>(seconds) * kPlaces[0] +
       static_cast<std::int64_t>(fraction) * kPlaces[decimals];
  return decimals > 0;
}

bool TakeCanUtilsId(LineScanner& in, LogFrame& frame) {
  std::uint64_t id = 0;
  const int digits = in.Hex(8, id);
  frame.id = static_cast<std::uint32_t>(id);
  if (digits == 3) {
    return frame.id <= kMost11Bits;
  }
  frame.error = (frame.id & kErrorFlag) != 0;
  frame.extended = !frame.error;
  frame.id &= ~kErrorFlag;
  return digits == 8 && frame.id <= kMost29Bits;
}

}  // namespace pipewright::hil
