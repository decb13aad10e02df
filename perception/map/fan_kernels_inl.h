// SPDX-License-Identifier: MIT
// The body of fan_kernels.h for one instruction set: PIPEWRIGHT_FAN_ISA names its namespace. Only
// for fan_kernels.cc and fan_kernels_avx2.cc. Loops over lanes are plain, for the compiler to turn
// into vectors; nothing inline of another header may be used, since the linker keeps one copy.
#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include "perception/map/fan_kernels.h"

namespace pipewright::fan::PIPEWRIGHT_FAN_ISA {
namespace {

constexpr int kLanes = 8;
#if defined(__AVX2__)
typedef std::int32_t Ints __attribute__((vector_size(32)));
#else
typedef std::int32_t Ints __attribute__((vector_size(16)));
#endif
constexpr int kWidth = sizeof(Ints) / sizeof(std::int32_t);

constexpr double kTicks = 1 << 29;  // of a ray's whole length
constexpr double kNever = 1e30;     // metres
constexpr double kFar = 1 << 30;    // ticks; one crossing more is below 2^31
constexpr float kFloatMax = 3.4028234663852886e38F;

/// Eight rays on their way.
struct Rays {
  float d[3][kLanes];          // direction
  double scale[kLanes];        // ticks a metre
  double t0_m[3][kLanes];      // to the first crossing
  double dt_m[3][kLanes];      // from one crossing to the next
  std::int32_t up[3][kLanes];  // 1: towards larger indices
  std::int32_t count[3][kLanes];
  std::int32_t starts[kLanes];   // 1: the ray leaves the origin's voxel
  std::int32_t bounded[kLanes];  // 1: ends where the box or the sure length does, not by itself

  alignas(32) std::int32_t first[3][kLanes];
  alignas(32) std::int32_t t[3][kLanes];
  alignas(32) std::int32_t dt[3][kLanes];
  alignas(32) std::int32_t stride[3][kLanes];
  alignas(32) std::int32_t slack[kLanes];
  alignas(32) std::int32_t horizon[kLanes];  // no crossing beyond
  alignas(32) std::int32_t steps[kLanes];    // crossings before it; -1: unsure
  alignas(32) std::int32_t index[kLanes];
  alignas(32) std::int32_t looked[kLanes];  // steps taken, one voxel each
};

inline double SquareRoot(double x) { return __builtin_sqrt(x); }

inline std::int32_t Floor(double x) {
  const auto i = static_cast<std::int32_t>(x);
  return i - (x < i ? 1 : 0);
}

/// The distance along each ray to its crossings.
inline void FindCrossings(const Origin& o, Rays* r) {
  for (int a = 0; a < 3; ++a) {
    for (int l = 0; l < kLanes; ++l) {
      const double d = r->d[a][l];
      const double size = d < 0 ? -d : d;
      const double border = d > 0 ? o.to_border_m[1][a] : -o.to_border_m[0][a];
      const double inverse = 1 / size;
      const double t0 = border > 0 ? border * inverse : 0;
      r->up[a][l] = d > 0 ? 1 : 0;
      r->t0_m[a][l] = size > 0 ? (t0 < kNever ? t0 : kNever) : kNever;
      const double dt = o.width_m * inverse;
      r->dt_m[a][l] = dt < kNever ? dt : kNever;
    }
  }
}

/// How far along each ray the box ends.
inline void FindWall(const Origin& o, const Rays& r, double* wall_m) {
  for (int l = 0; l < kLanes; ++l) {
    wall_m[l] = kNever;
  }
  for (int a = 0; a < 3; ++a) {
    for (int l = 0; l < kLanes; ++l) {
      const double cells = r.up[a][l] != 0 ? o.to_wall[1][a] : o.to_wall[0][a];
      const double t = r.t0_m[a][l] + cells * r.dt_m[a][l];
      wall_m[l] = t < wall_m[l] ? t : wall_m[l];
    }
  }
}

/// Ends the bounded rays after the crossings up to bound_m.
inline void CountCrossings(const double* bound_m, Rays* r) {
  constexpr double kJustBeyond = 1e-3;  // of the way from one crossing to the next
  for (int a = 0; a < 3; ++a) {
    for (int l = 0; l < kLanes; ++l) {
      const double crossings = (bound_m[l] - r->t0_m[a][l]) / r->dt_m[a][l] + (1 + kJustBeyond);
      const double sane = crossings > 0 ? (crossings < 1e6 ? crossings : 1e6) : 0;
      const auto count = static_cast<std::int32_t>(sane);
      r->count[a][l] = r->bounded[l] != 0 ? count : r->count[a][l];
    }
  }
}

/// Everything in ticks; what cannot be told for sure gets no steps.
inline void Schedule(const Origin& o, const double* bound_m, Rays* r) {
  double last[kLanes];
  double next[kLanes];
  double slack[kLanes];
  for (int l = 0; l < kLanes; ++l) {
    const int n = r->count[0][l] + r->count[1][l] + r->count[2][l];
    r->steps[l] = n - 1;
    slack[l] = 0.5 * n + 4;  // half a tick a crossing, one for the first, and something
    last[l] = -1;
    next[l] = 1e300;
  }
  for (int a = 0; a < 3; ++a) {
    for (int l = 0; l < kLanes; ++l) {
      const double t0 = r->t0_m[a][l] * r->scale[l];
      const double dt = r->dt_m[a][l] * r->scale[l];
      const double end = t0 + (r->count[a][l] - 1) * dt;
      last[l] = r->count[a][l] > 0 && end > last[l] ? end : last[l];
      next[l] = end + dt < next[l] ? end + dt : next[l];
      const double t0_far = t0 < kFar ? t0 : kFar;
      const double dt_far = dt < kFar ? dt : kFar;
      r->first[a][l] = r->t[a][l] = static_cast<std::int32_t>(t0_far + 0.5);
      r->dt[a][l] = static_cast<std::int32_t>(dt_far + 0.5);
      r->stride[a][l] = r->up[a][l] != 0 ? o.stride[a] : -o.stride[a];
      slack[l] = dt > 16 ? slack[l] : kTicks;
    }
  }
  for (int l = 0; l < kLanes; ++l) {
    const double end = r->bounded[l] != 0 ? bound_m[l] * r->scale[l] : kTicks;
    const bool apart = next[l] - last[l] > 2 * slack[l] + 2;
    const bool by_itself = last[l] < end - slack[l] && next[l] > end + slack[l];
    const bool at_bound = last[l] < end + slack[l] && end < kTicks * (1 + 1e-9);
    const bool sure = apart && (r->bounded[l] != 0 ? at_bound : by_itself);
    const bool goes = sure && r->steps[l] >= 0 && r->starts[l] != 0;
    r->steps[l] = goes ? r->steps[l] : -1;
    // Well before the last crossing: what lies between is as good as a tie with it.
    r->horizon[l] = goes ? static_cast<std::int32_t>(last[l] - 3 * slack[l]) - 1 : -1;
    r->slack[l] = slack[l] < 1e6 ? static_cast<std::int32_t>(slack[l]) : 1000000;
    r->index[l] = o.index;
  }
}

/// Segments to ends_W as OctoMap's computeRayKeys begins them. @returns a bit for each lane that
/// has nothing to pass: its end lies in the origin's voxel
inline unsigned AimAtEnds(const Origin& o, const float* ends_W, Rays* r) {
  std::int32_t at_home[kLanes];
  bool any_bounded = false;
  for (int l = 0; l < kLanes; ++l) {
    const float x = ends_W[3 * l] - o.p_W[0];
    const float y = ends_W[3 * l + 1] - o.p_W[1];
    const float z = ends_W[3 * l + 2] - o.p_W[2];
    const auto length = static_cast<float>(SquareRoot(static_cast<double>(x * x + y * y + z * z)));
    r->d[0][l] = x / length;
    r->d[1][l] = y / length;
    r->d[2][l] = z / length;
    r->scale[l] = kTicks / static_cast<double>(length);
    r->starts[l] = length > 0 && length <= kFloatMax ? 1 : 0;
    r->bounded[l] = 0;
    at_home[l] = 1;
  }
  FindCrossings(o, r);
  for (int a = 0; a < 3; ++a) {
    for (int l = 0; l < kLanes; ++l) {
      const double cell = o.width_inv * static_cast<double>(ends_W[3 * l + a]);
      const bool in_keys = cell >= -32768 && cell < 32768;
      const int off = Floor(in_keys ? cell : 0) - o.voxel[a];
      const int count = off < 0 ? -off : off;
      r->starts[l] &= in_keys ? 1 : 0;
      at_home[l] &= in_keys && off == 0 ? 1 : 0;
      r->count[a][l] = count;
      r->bounded[l] |= count > (r->up[a][l] != 0 ? o.to_wall[1][a] : o.to_wall[0][a]) ? 1 : 0;
    }
  }
  unsigned home = 0;
  for (int l = 0; l < kLanes; ++l) {
    any_bounded |= r->bounded[l] != 0;
    home |= at_home[l] != 0 ? 1U << l : 0U;
  }
  double wall_m[kLanes] = {};
  if (any_bounded) {
    FindWall(o, *r, wall_m);
    CountCrossings(wall_m, r);
    for (int l = 0; l < kLanes; ++l) {  // too near to its end to tell which comes first
      const double slack = 0.5 * (r->count[0][l] + r->count[1][l] + r->count[2][l]) + 8;
      const bool early = wall_m[l] * r->scale[l] < kTicks - slack;
      r->starts[l] &= r->bounded[l] == 0 || early ? 1 : 0;
    }
  }
  Schedule(o, wall_m, r);
  return home;
}

/// Rays of any length > 0 as OctoMap's castRay begins them, until the box or sure_m ends.
inline void AimAlong(const Origin& o, const float* directions_W, double sure_m, Rays* r) {
  for (int l = 0; l < kLanes; ++l) {
    const float x = directions_W[3 * l];
    const float y = directions_W[3 * l + 1];
    const float z = directions_W[3 * l + 2];
    const auto length = static_cast<float>(SquareRoot(static_cast<double>(x * x + y * y + z * z)));
    r->d[0][l] = x / length;
    r->d[1][l] = y / length;
    r->d[2][l] = z / length;
    r->starts[l] = length > 0 && length <= kFloatMax ? 1 : 0;
    r->bounded[l] = 1;
  }
  FindCrossings(o, r);
  double bound_m[kLanes];
  FindWall(o, *r, bound_m);
  for (int l = 0; l < kLanes; ++l) {
    bound_m[l] = bound_m[l] < sure_m ? bound_m[l] : sure_m;
    r->scale[l] = kTicks / bound_m[l];
  }
  CountCrossings(bound_m, r);
  Schedule(o, bound_m, r);
}

template <typename T>
inline void Load(const T* from, Ints* to) {
  __builtin_memcpy(to, from, sizeof *to);
}
template <typename T>
inline void Store(const Ints& from, T* to) {
  __builtin_memcpy(to, &from, sizeof from);
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

inline Ints Smaller(const Ints& a, const Ints& b) {
#if defined(__AVX2__)
  return (Ints)_mm256_min_epi32((__m256i)a, (__m256i)b);
#else
  const Ints less = a < b;
  return (a & less) | (b & ~less);
#endif
}

/// Steps kWidth rays until all have ended. Every step calls visit(index, going, &horizon): a lane
/// whose horizon it makes -1 goes no further.
template <typename Visit>
inline void Follow(Rays* r, int from, Visit* visit) {
  Ints tx, ty, tz, dx, dy, dz, sx, sy, sz, slack, horizon, index;
  Load(r->t[0] + from, &tx);
  Load(r->t[1] + from, &ty);
  Load(r->t[2] + from, &tz);
  Load(r->dt[0] + from, &dx);
  Load(r->dt[1] + from, &dy);
  Load(r->dt[2] + from, &dz);
  Load(r->stride[0] + from, &sx);
  Load(r->stride[1] + from, &sy);
  Load(r->stride[2] + from, &sz);
  Load(r->slack + from, &slack);
  Load(r->horizon + from, &horizon);
  Load(r->index + from, &index);
  Ints looked = {};
  for (;;) {
    const Ints nearest = Smaller(Smaller(tx, ty), tz);
    const Ints going = nearest <= horizon;
    if (LanesOf(going) == 0) {
      break;
    }
    // What is no farther than the slack is crossed at once: then there are fewer steps than
    // crossings in the end, and that tells.
    const Ints reach = (nearest + slack) | ~going;  // -1: below every crossing
    const Ints x = tx <= reach;
    const Ints y = ty <= reach;
    const Ints z = tz <= reach;
    tx += dx & x;
    ty += dy & y;
    tz += dz & z;
    index += (sx & x) + (sy & y) + (sz & z);
    looked -= going;
    visit->See(index, going, &horizon);
  }
  Store(tx, r->t[0] + from);
  Store(ty, r->t[1] + from);
  Store(tz, r->t[2] + from);
  Store(index, r->index + from);
  Store(looked, r->looked + from);
}

struct MarkVisit {
  std::uint32_t* bits;

  void See(const Ints& index, const Ints& going, Ints*) {
    const Ints word = Words(bits, index >> 5);
    const Ints unmarked = ~(word << (~index & 31)) >> 31;
    for (unsigned lanes = LanesOf(unmarked & going); lanes != 0; lanes &= lanes - 1) {
      const int i = index[__builtin_ctz(lanes)];
      bits[i >> 5] |= 1U << (i & 31);
    }
  }
};

/// What a ray sees in two bits a voxel.
struct LookVisit {
  const std::uint32_t* codes;
  bool unknown_ends;
  Ints unknown = {};
  Ints surface = {};
  Ints ended = {};

  void See(const Ints& index, const Ints& going, Ints* horizon) {
    typedef std::uint32_t Bits __attribute__((vector_size(sizeof(Ints))));
    const Ints word = Words(codes, index >> 4);
    const Ints code = (Ints)((Bits)word >> (Bits)((index & 15) << 1)) & 3;
    const Ints not_known = (code < 2) & going;
    const Ints hit = (code == 3) & going;
    unknown -= not_known;
    surface |= hit;
    const Ints end = unknown_ends ? hit | not_known : hit;
    ended |= end;
    *horizon |= end;
  }
};

/// The first n of 8 triples; what is missing lies at the origin.
inline const float* Eight(const float* triples, int n, const float* fill, float* room) {
  if (n >= kLanes) {
    return triples;
  }
  for (int i = 0; i < 3 * kLanes; ++i) {
    room[i] = i < 3 * n ? triples[i] : fill[i % 3];
  }
  return room;
}

/// Where the rays stopped, and whether they saw a voxel after every crossing. `ended`: by what they
/// saw, not by their length.
inline void FindEnds(const Rays& r, const std::int32_t* ended, std::int32_t* sure,
                     std::int32_t (*off)[kLanes]) {
  std::int32_t crossings[kLanes] = {};
  for (int a = 0; a < 3; ++a) {
    for (int l = 0; l < kLanes; ++l) {
      const double done = static_cast<double>(r.t[a][l] - r.first[a][l]) / r.dt[a][l];
      off[a][l] = static_cast<std::int32_t>(done + 0.5);
      crossings[l] += off[a][l];
    }
  }
  for (int l = 0; l < kLanes; ++l) {
    const bool whole = ended[l] != 0 || r.looked[l] == r.steps[l];
    sure[l] = r.steps[l] >= 0 && crossings[l] == r.looked[l] && whole ? 1 : 0;
  }
}

}  // namespace

int Mark(const Origin& o, const float* ends_W, int n, std::uint32_t* bits, int* redo) {
  int unsure = 0;
  float room[3 * kLanes];
  Rays rays;
  MarkVisit visit{bits};
  for (int i = 0; i < n; i += kLanes) {
    const unsigned home = AimAtEnds(o, Eight(ends_W + 3 * i, n - i, o.p_W, room), &rays);
    for (int from = 0; from < kLanes; from += kWidth) {
      Follow(&rays, from, &visit);
    }
    for (int l = 0; l < kLanes; ++l) {
      const bool sure =
          ((home >> l) & 1U) != 0 || (rays.steps[l] >= 0 && rays.looked[l] == rays.steps[l]);
      if (rays.steps[l] >= 0) {
        bits[o.index >> 5] |= 1U << (o.index & 31);
      }
      redo[unsure] = i + l;
      unsure += sure ? 0 : 1;
    }
  }
  return unsure;
}

/// What eight rays saw on their way.
struct Sights {
  alignas(32) std::int32_t unknown[kLanes];
  alignas(32) std::int32_t surface[kLanes];
  alignas(32) std::int32_t ended[kLanes];
  std::int32_t sure[kLanes];
  std::int32_t off[3][kLanes];
};

inline void Look(const std::uint32_t* codes, bool unknown_ends, Rays* rays, Sights* s) {
  for (int from = 0; from < kLanes; from += kWidth) {
    LookVisit visit{codes, unknown_ends};
    Follow(rays, from, &visit);
    Store(visit.unknown, s->unknown + from);
    Store(visit.surface, s->surface + from);
    Store(visit.ended, s->ended + from);
  }
  FindEnds(*rays, s->ended, s->sure, s->off);
}

inline void Tell(const Rays& rays, const Sights& s, int l, End* end) {
  end->unknown = s.unknown[l];
  end->surface = s.surface[l] != 0;
  end->by_sight = s.ended[l] != 0;
  for (int a = 0; a < 3; ++a) {
    end->off[a] = rays.up[a][l] != 0 ? s.off[a][l] : -s.off[a][l];
  }
}

int Trace(const Origin& o, const float* ends_W, int n, const std::uint32_t* codes, End* ends,
          int* redo) {
  const unsigned origin_code = (codes[o.index >> 4] >> ((o.index & 15) * 2)) & 3U;
  const bool in_surface = origin_code == 3;
  int unsure = 0;
  float room[3 * kLanes];
  Rays rays;
  Sights sights;
  for (int i = 0; i < n; i += kLanes) {
    const unsigned home = AimAtEnds(o, Eight(ends_W + 3 * i, n - i, o.p_W, room), &rays);
    for (int l = 0; l < kLanes; ++l) {
      rays.horizon[l] = in_surface ? -1 : rays.horizon[l];
    }
    Look(codes, false, &rays, &sights);
    for (int l = 0; l < kLanes && i + l < n; ++l) {
      End& end = ends[i + l];
      end = {};
      if (((home >> l) & 1U) != 0) {
        continue;
      }
      const bool goes = rays.steps[l] >= 0;
      if (in_surface && goes) {
        end.surface = end.by_sight = true;
        continue;
      }
      Tell(rays, sights, l, &end);
      end.unknown += origin_code < 2 ? 1 : 0;
      redo[unsure] = i + l;
      unsure += sights.sure[l] != 0 ? 0 : 1;
    }
  }
  return unsure;
}

int Cast(const Origin& o, const float* directions_W, int n, double sure_m, bool unknown_ends,
         const std::uint32_t* codes, End* ends, int* redo) {
  int unsure = 0;
  float room[3 * kLanes];
  Rays rays;
  Sights sights;
  const float nowhere[3] = {0, 0, 0};
  for (int i = 0; i < n; i += kLanes) {
    AimAlong(o, Eight(directions_W + 3 * i, n - i, nowhere, room), sure_m, &rays);
    Look(codes, unknown_ends, &rays, &sights);
    for (int l = 0; l < kLanes && i + l < n; ++l) {
      Tell(rays, sights, l, &ends[i + l]);
      redo[unsure] = i + l;
      unsure += sights.sure[l] != 0 ? 0 : 1;
    }
  }
  return unsure;
}

/// Of eight points: where they lie in what is marked, or -1 outside the box.
inline void FindCells(const Origin& o, const float* p, std::int32_t* index) {
  std::int32_t inside[kLanes];
  for (int l = 0; l < kLanes; ++l) {
    inside[l] = -1;
    index[l] = o.index;
  }
  for (int a = 0; a < 3; ++a) {
    for (int l = 0; l < kLanes; ++l) {
      const double cell = o.width_inv * static_cast<double>(p[3 * l + a]);
      const bool in_keys = cell >= -32768 && cell < 32768;
      const int off = Floor(in_keys ? cell : 0) - o.voxel[a];
      inside[l] &= in_keys && -o.to_wall[0][a] <= off && off <= o.to_wall[1][a] ? -1 : 0;
      index[l] += off * o.stride[a];
    }
  }
  for (int l = 0; l < kLanes; ++l) {
    index[l] |= ~inside[l];
  }
}

void Cells(const Origin& o, const float* points_W, int n, std::int32_t* hit_index) {
  float room[3 * kLanes];
  for (int i = 0; i < n; i += kLanes) {
    std::int32_t index[kLanes];
    FindCells(o, Eight(points_W + 3 * i, n - i, o.p_W, room), index);
    const int count = n - i < kLanes ? n - i : kLanes;
    __builtin_memcpy(hit_index + i, index, sizeof(index[0]) * static_cast<unsigned>(count));
  }
}

void Clip(const Origin& o, const float* points_W, int n, double max_range_m, float* ends_W,
          std::int32_t* hit_index) {
  if (max_range_m < 0) {
    __builtin_memcpy(ends_W, points_W, sizeof(float) * 3 * static_cast<unsigned>(n));
    PIPEWRIGHT_FAN_ISA::Cells(o, points_W, n, hit_index);
    return;
  }
  float room[3 * kLanes];
  const auto range = static_cast<float>(max_range_m);
  for (int i = 0; i < n; i += kLanes) {
    const float* const p = Eight(points_W + 3 * i, n - i, o.p_W, room);
    float end[3 * kLanes];
    std::int32_t clipped[kLanes];
    std::int32_t index[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const float x = p[3 * l] - o.p_W[0];
      const float y = p[3 * l + 1] - o.p_W[1];
      const float z = p[3 * l + 2] - o.p_W[2];
      const double distance = SquareRoot(static_cast<double>(x * x + y * y + z * z));
      const auto length = static_cast<float>(distance);
      const bool within = distance <= max_range_m;
      const bool divide = distance > 0;
      end[3 * l] = within ? p[3 * l] : o.p_W[0] + (divide ? x / length : x) * range;
      end[3 * l + 1] = within ? p[3 * l + 1] : o.p_W[1] + (divide ? y / length : y) * range;
      end[3 * l + 2] = within ? p[3 * l + 2] : o.p_W[2] + (divide ? z / length : z) * range;
      clipped[l] = within ? 0 : -1;
    }
    FindCells(o, p, index);
    const int count = n - i < kLanes ? n - i : kLanes;
    for (int l = 0; l < count; ++l) {
      hit_index[i + l] = index[l] | clipped[l];
    }
    __builtin_memcpy(ends_W + 3 * i, end, sizeof(float) * 3 * static_cast<unsigned>(count));
  }
}

}  // namespace pipewright::fan::PIPEWRIGHT_FAN_ISA
