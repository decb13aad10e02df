// SPDX-License-Identifier: MIT
// From reset to main on a Cortex-M7 with memory.ld: vector table, FPU, .data and .bss,
// constructors, the command line by semihosting; and the heap, which is for start alone.
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

extern "C" {
extern std::uint64_t data_begin[];
extern std::uint64_t data_end[];
extern const std::uint64_t data_image[];
extern std::uint64_t bss_begin[];
extern std::uint64_t bss_end[];
extern std::uint64_t stack_top[];
extern char heap_begin[];
extern char heap_end[];
using Constructor = void (*)();
extern const Constructor first_constructor[];
extern const Constructor last_constructor[];

void initialise_monitor_handles();  // newlib's: opens stdin, stdout and stderr by semihosting
int Main(int argc, char** argv) asm("main");  // C++ itself may not call main
[[noreturn]] void Reset();
}

namespace {

constexpr int kGetCommandLine = 0x15;
constexpr int kExitExtended = 0x20;
constexpr std::uintptr_t kApplicationExit = 0x20026;
constexpr std::uintptr_t kRunTimeError = 0x20023;
constexpr int kMostArguments = 16;

std::intptr_t Semihost(std::intptr_t operation, void* block) {
  register std::intptr_t r0 asm("r0") = operation;
  register void* r1 asm("r1") = block;
  asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

[[noreturn]] void Exit(std::uintptr_t reason, int code) {
  std::uintptr_t block[2] = {reason, static_cast<std::uintptr_t>(code)};
  Semihost(kExitExtended, block);
  while (true) {
  }
}

/// Any fault: nothing can be mended here.
[[noreturn]] void Fault() { Exit(kRunTimeError, 70); }

char command_line[1024];

/// Splits the command line at spaces; @returns argc
int Arguments(char** argv) {
  struct {
    char* text;
    int bytes;
  } block{command_line, sizeof(command_line)};
  int argc = 0;
  if (Semihost(kGetCommandLine, &block) == 0) {
    for (char* word = std::strtok(command_line, " "); word != nullptr && argc < kMostArguments;
         word = std::strtok(nullptr, " ")) {
      argv[argc++] = word;
    }
  }
  argv[argc] = nullptr;
  return argc;
}

}  // namespace

extern "C" {

/// Names the program to whoever registers a destructor; none is ever run.
void* __dso_handle = nullptr;

using Handler = void (*)();

/// The first word is the stack's top, then reset and the fourteen system exceptions. No device of
/// the board is used, so no interrupt comes.
[[gnu::section(".vectors"), gnu::used]] const struct {
  const void* stack;
  Handler handlers[15];
} vectors = {stack_top,
             {Reset, Fault, Fault, Fault, Fault, Fault, Fault, Fault, Fault, Fault, Fault, Fault,
              Fault, Fault, Fault}};

[[noreturn]] void Reset() {
  // Coprocessors 10 and 11, full access: before any instruction of the FPU.
  auto* const coprocessor_access = reinterpret_cast<volatile std::uint32_t*>(0xE000ED88);
  *coprocessor_access = *coprocessor_access | 0xFU << 20;
  asm volatile("dsb\n isb" : : : "memory");
  const std::uint64_t* image = data_image;
  for (std::uint64_t* to = data_begin; to != data_end; ++to) {
    *to = *image++;
  }
  for (std::uint64_t* to = bss_begin; to != bss_end; ++to) {
    *to = 0;
  }
  initialise_monitor_handles();
  for (const Constructor* constructor = first_constructor; constructor != last_constructor;
       ++constructor) {
    (*constructor)();
  }
  static char* argv[kMostArguments + 1];
  const int argc = Arguments(argv);
  const int code = Main(argc, argv);
  std::fflush(nullptr);
  Exit(kApplicationExit, code);
}

/// newlib's heap.
void* _sbrk(std::ptrdiff_t bytes) {
  static char* used = heap_begin;
  if (bytes > heap_end - used) {
    errno = ENOMEM;
    return reinterpret_cast<void*>(-1);
  }
  char* const block = used;
  used += bytes;
  return block;
}

void _exit(int code) { Exit(kApplicationExit, code); }
}

// Without exceptions, no memory is the end. libstdc++'s own would bring the unwinder along.

void* operator new(std::size_t bytes) {
  void* const block = std::malloc(bytes);
  if (block == nullptr) {
    std::fputs("out of memory\n", stderr);
    std::abort();
  }
  return block;
}

void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t /*bytes*/) noexcept { std::free(block); }

namespace std {

void __throw_length_error(const char* what) {
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}
void __throw_bad_alloc() { std::abort(); }
void __throw_bad_array_new_length() { std::abort(); }

}  // namespace std
