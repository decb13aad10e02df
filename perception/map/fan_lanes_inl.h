// SPDX-License-Identifier: MIT
// Only for fan_kernels_inl.h: numbers side by side, in the widest register that every machine of
// the instruction set has. Nothing inline of another header may be used here or there, since the
// linker would keep one copy of it for all machines.
#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include <cstdint>

namespace pipewright::fan::PIPEWRIGHT_FAN_ISA {
namespace {

constexpr int kLanes = 8;
#if defined(__AVX2__)
constexpr int kBytes = 32;
#else
constexpr int kBytes = 16;
#endif
typedef std::int32_t Ints __attribute__((vector_size(kBytes)));
typedef double Doubles __attribute__((vector_size(kBytes)));
typedef std::int64_t Masks __attribute__((vector_size(kBytes)));  // of Doubles
typedef float Floats __attribute__((vector_size(kBytes / 2)));    // as many as Doubles
typedef std::int32_t Counts __attribute__((vector_size(kBytes / 2)));
typedef std::uint32_t Bits __attribute__((vector_size(kBytes / 2)));  // Counts to shift
constexpr int kWidth = kBytes / 4;
constexpr int kHalf = kBytes / 8;

template <typename Vector, typename T>
inline void Load(const T* from, Vector* to) {
  __builtin_memcpy(to, from, sizeof *to);
}
template <typename Vector, typename T>
inline void Store(const Vector& from, T* to) {
  __builtin_memcpy(to, &from, sizeof from);
}

inline Doubles ToDoubles(const Floats& v) { return __builtin_convertvector(v, Doubles); }
inline Doubles ToDoubles(const Counts& v) { return __builtin_convertvector(v, Doubles); }
inline Floats ToFloats(const Doubles& v) { return __builtin_convertvector(v, Floats); }
inline Counts ToCounts(const Doubles& v) { return __builtin_convertvector(v, Counts); }
inline Counts ToCounts(const Masks& v) { return __builtin_convertvector(v, Counts); }
inline Masks ToMasks(const Counts& v) { return __builtin_convertvector(v, Masks); }

/// The second where the first is no number.
inline Doubles Lesser(const Doubles& a, const Doubles& b) { return a < b ? a : b; }
inline Doubles Greater(const Doubles& a, const Doubles& b) { return a > b ? a : b; }

inline Doubles SquareRoot(const Doubles& v) {
#if defined(__AVX2__)
  return _mm256_sqrt_pd(v);
#else
  Doubles root;
  for (int l = 0; l < kHalf; ++l) {
    root[l] = __builtin_sqrt(v[l]);
  }
  return root;
#endif
}

/// As good as the root in double, rounded to float: 53 bits are more than twice 24 and one.
inline Floats SquareRoot(const Floats& v) {
#if defined(__AVX2__)
  return _mm_sqrt_ps(v);
#else
  Floats root;
  for (int l = 0; l < kHalf; ++l) {
    root[l] = __builtin_sqrtf(v[l]);
  }
  return root;
#endif
}

/// floor, or something below -2^20 for what is beyond +-2^20 or no number.
inline Counts Floor(const Doubles& v) {
#if defined(__AVX2__)
  return ToCounts(_mm256_floor_pd(v));  // INT_MIN for what does not fit
#else
  constexpr double kFit = 1 << 20;
  Counts floor;
  for (int l = 0; l < kHalf; ++l) {
    const bool fits = -kFit <= v[l] && v[l] <= kFit;
    floor[l] = static_cast<std::int32_t>(fits ? v[l] : -2 * kFit);
    floor[l] -= v[l] < floor[l] ? 1 : 0;
  }
  return floor;
#endif
}

/// Coordinate `axis` of kHalf points.
inline Floats Coordinates(const float* points, int axis) {
#if defined(__AVX2__)
  return Floats{points[axis], points[3 + axis], points[6 + axis], points[9 + axis]};
#else
  return Floats{points[axis], points[3 + axis]};
#endif
}

/// A bit for each lane of a mask.
inline unsigned LanesOf(const Ints& mask) {
#if defined(__AVX2__)
  return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps((__m256i)mask)));
#else
  unsigned lanes = 0;
  for (int l = 0; l < kWidth; ++l) {
    lanes |= mask[l] != 0 ? 1U << l : 0U;
  }
  return lanes;
#endif
}

inline unsigned LanesOf(const Masks& mask) {
#if defined(__AVX2__)
  return static_cast<unsigned>(_mm256_movemask_pd((__m256d)mask));
#else
  unsigned lanes = 0;
  for (int l = 0; l < kHalf; ++l) {
    lanes |= mask[l] != 0 ? 1U << l : 0U;
  }
  return lanes;
#endif
}

inline Ints Words(const std::uint32_t* words, const Ints& at) {
#if defined(__AVX2__)
  return (Ints)_mm256_i32gather_epi32(reinterpret_cast<const int*>(words), (__m256i)at, 4);
#else
  Ints found;
  for (int l = 0; l < kWidth; ++l) {
    found[l] = static_cast<std::int32_t>(words[at[l]]);
  }
  return found;
#endif
}

inline Counts Words(const std::uint32_t* words, const Counts& at) {
#if defined(__AVX2__)
  return (Counts)_mm_i32gather_epi32(reinterpret_cast<const int*>(words), (__m128i)at, 4);
#else
  Counts found;
  for (int l = 0; l < kHalf; ++l) {
    found[l] = static_cast<std::int32_t>(words[at[l]]);
  }
  return found;
#endif
}

#if defined(__AVX2__)
/// Of each set of lanes their numbers, in order.
struct LaneLists {
  constexpr LaneLists() {
    for (unsigned lanes = 0; lanes < 256; ++lanes) {
      int n = 0;
      for (unsigned l = 0; l < kLanes; ++l) {
        if (((lanes >> l) & 1U) != 0) {
          of[lanes][n++] = static_cast<std::uint8_t>(l);
        }
      }
    }
  }
  std::uint8_t of[256][kLanes]{};
};
constexpr LaneLists kLaneLists;
#endif

/// Writes those lanes of v one after the other; there must be room for all. @returns how many
inline int Pack(const Ints& v, unsigned lanes, std::int32_t* to) {
#if defined(__AVX2__)
  const __m128i list = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(kLaneLists.of[lanes]));
  Store(_mm256_permutevar8x32_epi32((__m256i)v, _mm256_cvtepu8_epi32(list)), to);
  return __builtin_popcount(lanes);
#else
  int n = 0;
  for (int l = 0; l < kWidth; ++l) {
    to[n] = v[l];
    n += static_cast<int>((lanes >> l) & 1U);
  }
  return n;
#endif
}

inline Ints Smaller(const Ints& a, const Ints& b) {
#if defined(__AVX2__)
  return (Ints)_mm256_min_epi32((__m256i)a, (__m256i)b);
#else
  const Ints less = a < b;
  return (a & less) | (b & ~less);
#endif
}

inline unsigned LanesOf(const Counts& mask) {
#if defined(__AVX2__)
  return static_cast<unsigned>(_mm_movemask_ps(_mm_castsi128_ps((__m128i)mask)));
#else
  unsigned lanes = 0;
  for (int l = 0; l < kHalf; ++l) {
    lanes |= mask[l] != 0 ? 1U << l : 0U;
  }
  return lanes;
#endif
}

}  // namespace
}  // namespace pipewright::fan::PIPEWRIGHT_FAN_ISA
