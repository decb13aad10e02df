// SPDX-License-Identifier: MIT
// Whether instruction_counter counts what was run: loops of a known number of instructions, under
// QEMU with the plugin. Exit code 0: every one to the instruction; 1: not; 2: nothing counts.
#include <cstdint>
#include <cstdio>

#include "tests/timing/instruction_count.h"

namespace {

/// Two instructions a turn.
[[gnu::noinline]] void Turn(std::uint64_t turns) {
#if defined(__x86_64__)
  asm volatile("1: dec %0\n jnz 1b" : "+r"(turns) : : "cc");
#elif defined(__aarch64__)
  asm volatile("1: subs %0, %0, #1\n b.ne 1b" : "+r"(turns) : : "cc");
#else
#error "no loop for this machine"
#endif
}

/// With what the call and the reading take.
[[gnu::noinline]] std::uint64_t Cost(const pipewright::timing::InstructionCount& instructions,
                                     std::uint64_t turns) {
  const std::uint64_t before = instructions.Now();
  Turn(turns);
  return instructions.Now() - before;
}

}  // namespace

int main() {
  const pipewright::timing::InstructionCount instructions;
  if (!instructions.counting()) {
    std::fprintf(stderr, "known_loop: nothing counts\n");
    return 2;
  }
  const std::uint64_t around = Cost(instructions, 1) - 2;
  constexpr std::uint64_t kTurns[] = {1, 2, 3, 1000, 1000, 123457};
  for (const std::uint64_t turns : kTurns) {
    const std::uint64_t cost = Cost(instructions, turns) - around;
    if (cost != 2 * turns) {
      std::fprintf(stderr, "known_loop: %ju instructions for %ju turns\n", std::uintmax_t{cost},
                   std::uintmax_t{turns});
      return 1;
    }
  }
  return around < 100 ? 0 : 1;
}
