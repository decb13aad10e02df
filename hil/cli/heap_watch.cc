// SPDX-License-Identifier: MIT
#include "hil/cli/heap_watch.h"

#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PIPEWRIGHT_OWN_MALLOC 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define PIPEWRIGHT_OWN_MALLOC 0
#endif
#endif
#ifndef PIPEWRIGHT_OWN_MALLOC
#define PIPEWRIGHT_OWN_MALLOC 1
#endif

namespace {
thread_local int watches = 0;
thread_local std::uint64_t allocations_seen = 0;
}  // namespace

#if PIPEWRIGHT_OWN_MALLOC
// glibc's own entry points: the process's malloc family becomes these few lines in front of them.
// operator new and aligned_alloc's relatives come through them, or through memalign below.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  allocations_seen += watches > 0;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  allocations_seen += watches > 0;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  allocations_seen += watches > 0;
  return __libc_realloc(old, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  allocations_seen += watches > 0;
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  allocations_seen += watches > 0;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  allocations_seen += watches > 0;
  *out = __libc_memalign(alignment, size);
  return *out == nullptr ? 12 /* ENOMEM */ : 0;
}
}
#endif

namespace pipewright::hil {

HeapWatch::HeapWatch() : before_(allocations_seen) { ++watches; }
HeapWatch::~HeapWatch() { --watches; }
std::uint64_t HeapWatch::allocations() const { return allocations_seen - before_; }
bool HeapWatch::Counting() { return PIPEWRIGHT_OWN_MALLOC != 0; }

}  // namespace pipewright::hil
