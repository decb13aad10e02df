// SPDX-License-Identifier: MIT
#define PIPEWRIGHT_FAN_ISA baseline
#include "perception/map/fan_kernels_inl.h"

namespace pipewright::fan {

#if defined(PIPEWRIGHT_FAN_AVX2)
namespace avx2 {
void Clip(const Origin& o, const float* points_W, int n, double max_range_m, float* ends_W,
          std::int32_t* hit_index);
void Cells(const Origin& o, const float* points_W, int n, std::int32_t* hit_index);
int Mark(const Origin& o, const float* ends_W, int n, std::uint32_t* bits, int* redo);
int Trace(const Origin& o, const float* ends_W, int n, const std::uint32_t* codes, End* ends,
          int* redo);
int Cast(const Origin& o, const float* directions_W, int n, double sure_m, bool unknown_ends,
         const std::uint32_t* codes, End* ends, int* redo);
int Gather(const CellOrigin& o, const double* directions, int n, double length, Search* search,
           int* redo);
int FindBlocked(const CellOrigin& o, const double* directions, int n, double length,
                const std::uint32_t* codes, std::uint8_t* blocked, int* redo);
}  // namespace avx2
#else
namespace avx2 = baseline;
#endif

namespace {

bool MachineHasAvx2() {
#if defined(PIPEWRIGHT_FAN_AVX2)
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

bool use_avx2 = MachineHasAvx2();

}  // namespace

bool UseBaseline(bool baseline_only) {
  use_avx2 = !baseline_only && MachineHasAvx2();
  return use_avx2;
}

void Clip(const Origin& o, const float* points_W, int n, double max_range_m, float* ends_W,
          std::int32_t* hit_index) {
  (use_avx2 ? avx2::Clip : baseline::Clip)(o, points_W, n, max_range_m, ends_W, hit_index);
}

void Cells(const Origin& o, const float* points_W, int n, std::int32_t* hit_index) {
  (use_avx2 ? avx2::Cells : baseline::Cells)(o, points_W, n, hit_index);
}

int Mark(const Origin& o, const float* ends_W, int n, std::uint32_t* bits, int* redo) {
  return (use_avx2 ? avx2::Mark : baseline::Mark)(o, ends_W, n, bits, redo);
}

int Trace(const Origin& o, const float* ends_W, int n, const std::uint32_t* codes, End* ends,
          int* redo) {
  return (use_avx2 ? avx2::Trace : baseline::Trace)(o, ends_W, n, codes, ends, redo);
}

int Cast(const Origin& o, const float* directions_W, int n, double sure_m, bool unknown_ends,
         const std::uint32_t* codes, End* ends, int* redo) {
  return (use_avx2 ? avx2::Cast : baseline::Cast)(o, directions_W, n, sure_m, unknown_ends, codes,
                                                  ends, redo);
}

int Gather(const CellOrigin& o, const double* directions, int n, double length, Search* search,
           int* redo) {
  return (use_avx2 ? avx2::Gather : baseline::Gather)(o, directions, n, length, search, redo);
}

int FindBlocked(const CellOrigin& o, const double* directions, int n, double length,
                const std::uint32_t* codes, std::uint8_t* blocked, int* redo) {
  return (use_avx2 ? avx2::FindBlocked : baseline::FindBlocked)(o, directions, n, length, codes,
                                                                blocked, redo);
}

}  // namespace pipewright::fan
