// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace pipewright::timing {

/// The instructions that this program has run so far, as QEMU with the plugin instruction_counter
/// counts them in the file that PIPEWRIGHT_INSTRUCTION_COUNT names:
///
///   export PIPEWRIGHT_INSTRUCTION_COUNT=/tmp/count
///   qemu-x86_64 -plugin ./libinstruction_counter.so,count=/tmp/count ./program
///
///   const InstructionCount instructions;
///   const std::uint64_t before = instructions.Now();
///   ...
///   const std::uint64_t cost = instructions.Now() - before;   // with the few of Now() itself
class InstructionCount {
 public:
  InstructionCount();
  ~InstructionCount();
  InstructionCount(const InstructionCount&) = delete;
  InstructionCount& operator=(const InstructionCount&) = delete;

  /// False: nothing counts (not under the plugin, no file, or it stands still); Now() is then 0.
  bool counting() const { return page_ != nullptr; }

  std::uint64_t Now() const { return page_ == nullptr ? 0 : *page_; }

 private:
  const volatile std::uint64_t* page_ = nullptr;
};

}  // namespace pipewright::timing
