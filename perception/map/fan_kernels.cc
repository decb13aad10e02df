// SPDX-License-Identifier: MIT
#define PIPEWRIGHT_FAN_ISA baseline
#include "perception/map/fan_kernels_inl.h"

namespace pipewright::fan {
namespace {

const Table* Best() {
#if defined(PIPEWRIGHT_FAN_AVX2)
  return __builtin_cpu_supports("avx2") != 0 ? &avx2::kTable : &baseline::kTable;
#else
  return &baseline::kTable;
#endif
}

const Table* table = Best();

}  // namespace

bool UseBaseline(bool baseline_only) {
  table = baseline_only ? &baseline::kTable : Best();
  return table != &baseline::kTable;
}

void Clip(const Origin& o, const float* points_W, int n, double max_range_m, float* ends_W,
          std::int32_t* hit_index) {
  table->clip(o, points_W, n, max_range_m, ends_W, hit_index);
}

void Cells(const Origin& o, const float* points_W, int n, std::int32_t* hit_index) {
  table->cells(o, points_W, n, hit_index);
}

int Mark(const Origin& o, const float* ends_W, int n, std::uint32_t* bits, int* redo) {
  return table->mark(o, ends_W, n, bits, redo);
}

int Trace(const Origin& o, const float* ends_W, int n, const std::uint32_t* codes, End* ends,
          int* redo) {
  return table->trace(o, ends_W, n, codes, ends, redo);
}

int Cast(const Origin& o, const float* directions_W, int n, double sure_m, bool unknown_ends,
         const std::uint32_t* codes, End* ends, int* redo) {
  return table->cast(o, directions_W, n, sure_m, unknown_ends, codes, ends, redo);
}

int Gather(const CellOrigin& o, const double* directions, int n, double length, Search* search,
           int* redo) {
  return table->gather(o, directions, n, length, search, redo);
}

int FindBlocked(const CellOrigin& o, const double* directions, int n, double length,
                const std::uint32_t* codes, std::uint8_t* blocked, int* redo) {
  return table->find_blocked(o, directions, n, length, codes, blocked, redo);
}

}  // namespace pipewright::fan
