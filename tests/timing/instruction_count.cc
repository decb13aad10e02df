// SPDX-License-Identifier: MIT
#include "tests/timing/instruction_count.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>

namespace pipewright::timing {
namespace {

constexpr std::size_t kCounter = sizeof(std::uint64_t);

}  // namespace

InstructionCount::InstructionCount() {
  const char* path = std::getenv("PIPEWRIGHT_INSTRUCTION_COUNT");
  const int file = path == nullptr ? -1 : open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) {
    return;
  }
  void* page = mmap(nullptr, kCounter, PROT_READ, MAP_SHARED, file, 0);
  close(file);
  if (page == MAP_FAILED) {
    return;
  }
  page_ = static_cast<const volatile std::uint64_t*>(page);
  // A file that a former run left counts nothing.
  if (const std::uint64_t first = *page_; *page_ == first) {
    munmap(page, kCounter);
    page_ = nullptr;
  }
}

InstructionCount::~InstructionCount() {
  if (page_ != nullptr) {
    munmap(const_cast<std::uint64_t*>(page_), kCounter);
  }
}

}  // namespace pipewright::timing
