// SPDX-License-Identifier: MIT
#include "tests/timing/replay/stack_mark.h"

#include <cstdint>

namespace pipewright::timing {
namespace {

constexpr std::uint32_t kPaint = 0x5AC3965AU;
constexpr int kWords = kPaintedStack / 4;

// One function for both, so that both times its array lies at the same place: where the frames of
// the caller's other calls lie in between.
[[gnu::noinline]] int PaintOrRead(bool paint) {
  std::uint32_t array[kWords];
  volatile std::uint32_t* words = array;
  asm volatile("" : "+r"(words) : : "memory");  // for all the compiler knows, this wrote to them
  if (paint) {
    for (int i = 0; i < kWords; ++i) {
      words[i] = kPaint;
    }
    return 0;
  }
  int untouched = 0;
  while (untouched < kWords && words[untouched] == kPaint) {
    ++untouched;
  }
  return 4 * (kWords - untouched);
}

}  // namespace

void PaintStack() { static_cast<void>(PaintOrRead(true)); }

int StackUsed() { return PaintOrRead(false); }

}  // namespace pipewright::timing
