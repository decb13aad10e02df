// SPDX-License-Identifier: MIT
// A TCG plugin for QEMU 7.2: counts every guest instruction, one by one and exactly, into eight
// bytes that the guest itself may map and read (see instruction_count.h), and, where the guest can
// map nothing, writes how many lay between two addresses.
//
//   qemu-aarch64 -plugin ./libinstruction_counter.so,count=FILE ./program
//   qemu-system-arm ... -plugin ./libinstruction_counter.so,start=0x...,stop=0x...,calls=FILE
//
//   count=FILE            the total so far, in FILE's first eight bytes, host byte order
//   start=, stop=ADDRESS  of an instruction each: from start, included, to stop, excluded
//   calls=FILE            a line of text for each such span: its instructions
//
// Counted is one by one, not by translated block: of a block that an exception leaves early, only
// what was run counts. The guest is to have one thread: the addition is not atomic.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

// What is used of QEMU's plugin interface, version 1 (docs/devel/tcg-plugins in its manual). The
// declarations are ours: Debian ships no header.
extern "C" {
struct qemu_plugin_tb;
struct qemu_plugin_insn;
using PluginId = std::uint64_t;
using OnTranslate = void (*)(PluginId, qemu_plugin_tb*);
using OnExecute = void (*)(unsigned cpu, void* data);
using OnExit = void (*)(PluginId, void* data);

void qemu_plugin_register_vcpu_tb_trans_cb(PluginId id, OnTranslate callback);
void qemu_plugin_register_vcpu_insn_exec_inline(qemu_plugin_insn* insn, int operation, void* to,
                                                std::uint64_t value);
void qemu_plugin_register_vcpu_insn_exec_cb(qemu_plugin_insn* insn, OnExecute callback, int flags,
                                            void* data);
void qemu_plugin_register_atexit_cb(PluginId id, OnExit callback, void* data);
std::size_t qemu_plugin_tb_n_insns(const qemu_plugin_tb* tb);
qemu_plugin_insn* qemu_plugin_tb_get_insn(const qemu_plugin_tb* tb, std::size_t index);
std::uint64_t qemu_plugin_insn_vaddr(const qemu_plugin_insn* insn);

[[gnu::visibility("default")]] extern const int qemu_plugin_version = 1;
[[gnu::visibility("default")]] int qemu_plugin_install(PluginId id, const void* info, int argc,
                                                       char** argv);
}

namespace {

constexpr int kAddU64 = 0;
constexpr int kNoRegisters = 0;
constexpr std::size_t kPage = 4096;

std::uint64_t own_count = 0;
std::uint64_t* count = &own_count;
std::uint64_t start_address = 0;
std::uint64_t stop_address = 0;
std::uint64_t started_at = 0;
bool started = false;
std::FILE* calls = nullptr;

// QEMU runs a callback before the instruction's own addition.
void Start(unsigned /*cpu*/, void* /*data*/) {
  started_at = *count;
  started = true;
}

void Stop(unsigned /*cpu*/, void* /*data*/) {
  if (started && calls != nullptr) {
    std::fprintf(calls, "%" PRIu64 "\n", *count - started_at);
  }
  started = false;
}

void Translate(PluginId /*id*/, qemu_plugin_tb* tb) {
  const std::size_t n = qemu_plugin_tb_n_insns(tb);
  for (std::size_t i = 0; i < n; ++i) {
    qemu_plugin_insn* insn = qemu_plugin_tb_get_insn(tb, i);
    qemu_plugin_register_vcpu_insn_exec_inline(insn, kAddU64, count, 1);
    const std::uint64_t address = qemu_plugin_insn_vaddr(insn);
    if (start_address != 0 && address == start_address) {
      qemu_plugin_register_vcpu_insn_exec_cb(insn, Start, kNoRegisters, nullptr);
    }
    if (stop_address != 0 && address == stop_address) {
      qemu_plugin_register_vcpu_insn_exec_cb(insn, Stop, kNoRegisters, nullptr);
    }
  }
}

void Close(PluginId /*id*/, void* /*data*/) {
  if (calls != nullptr) {
    std::fclose(calls);
  }
}

/// The file's first page, made and zeroed; nullptr: it cannot be.
std::uint64_t* Map(const char* path) {
  const int file = open(path, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0 || ftruncate(file, kPage) != 0) {
    return nullptr;
  }
  void* page = mmap(nullptr, kPage, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  close(file);
  return page == MAP_FAILED ? nullptr : static_cast<std::uint64_t*>(page);
}

/// The rest of `argument` behind "key="; nullptr: it is another.
const char* Value(const char* argument, const char* key) {
  const std::size_t n = std::strlen(key);
  return std::strncmp(argument, key, n) == 0 && argument[n] == '=' ? argument + n + 1 : nullptr;
}

bool Take(const char* argument) {
  if (const char* path = Value(argument, "count")) {
    count = Map(path);
    return count != nullptr;
  }
  if (const char* path = Value(argument, "calls")) {
    calls = std::fopen(path, "w");
    return calls != nullptr;
  }
  for (const auto& [key, address] : {std::pair{"start", &start_address}, {"stop", &stop_address}}) {
    if (const char* text = Value(argument, key)) {
      char* end = nullptr;
      *address = std::strtoull(text, &end, 0);
      return *address != 0 && *end == '\0';
    }
  }
  return false;
}

}  // namespace

int qemu_plugin_install(PluginId id, const void* /*info*/, int argc, char** argv) {
  for (int i = 0; i < argc; ++i) {
    if (!Take(argv[i])) {
      std::fprintf(stderr, "instruction_counter: cannot take '%s'\n", argv[i]);
      return -1;
    }
  }
  qemu_plugin_register_vcpu_tb_trans_cb(id, Translate);
  qemu_plugin_register_atexit_cb(id, Close, nullptr);
  return 0;
}
