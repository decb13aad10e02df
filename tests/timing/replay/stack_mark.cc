// SPDX-License-Identifier: MIT
#include "tests/timing/replay/stack_mark.h"

#include <cstdint>

namespace pipewright::timing {
namespace {

constexpr std::uint32_t kPaint = 0x5AC3965AU;
constexpr int kWords = kPaintedStack / 4;

// The address of an array in this frame, which is where the next frame of the same caller lies
// too. Through a volatile pointer: the words below are nobody's, as far as the language goes.
[[gnu::noinline]] volatile std::uint32_t* Below() {
  volatile std::uint32_t here = 0;
  volatile std::uintptr_t address = reinterpret_cast<std::uintptr_t>(&here);
  return reinterpret_cast<volatile std::uint32_t*>((address & ~std::uintptr_t{15}) - 256);
}

}  // namespace

[[gnu::noinline]] void PaintStack() {
  volatile std::uint32_t* top = Below();
  for (int i = 1; i <= kWords; ++i) {
    top[-i] = kPaint;
  }
}

[[gnu::noinline]] int StackUsed() {
  volatile std::uint32_t* top = Below();
  for (int i = kWords; i >= 1; --i) {
    if (top[-i] != kPaint) {
      return 4 * i + 256;
    }
  }
  return 0;
}

}  // namespace pipewright::timing
