// SPDX-License-Identifier: MIT
// Only for fan_kernels_inl.h: rays whose crossings lie too near to one another for ticks, stepped
// in OctoMap's own doubles, so that whatever ties there are, they are decided as OctoMap does.
#include "perception/map/fan_search_inl.h"

namespace pipewright::fan::PIPEWRIGHT_FAN_ISA {
namespace {

// Crossings of three axes in one number, a field each. A field holds twice the keys' whole range,
// and its top bit is set once it is below 0.
constexpr int kField = 20;
constexpr std::int64_t kOneCrossing[3] = {1, std::int64_t{1} << kField,
                                          std::int64_t{1} << 2 * kField};
constexpr std::int64_t kBelow0 = (kOneCrossing[0] + kOneCrossing[1] + kOneCrossing[2])
                                 << (kField - 1);

// Sides of kHalf rays each: while one waits for a sum, the other goes on.
constexpr int kSides = 2;
constexpr int kMany = kSides * kHalf;

/// kHalf rays on their way, in the numbers of RayWalk.
struct ExactRays {
  Doubles t_m[3];   // along the ray to the next crossing
  Doubles dt_m[3];  // from one crossing to the next
  Doubles length_m;
  Masks stride[3];  // of the index, with the direction's sign
  Masks index;
  Masks crossed;  // so far
  Masks to_end;   // crossings to the end's voxel
  Masks to_wall;  // and to the box's last
  Masks going;
};

/// Rays along v. @returns their length
inline Floats AimExactly(const Origin& o, const Floats* v, Aim* aim, ExactRays* r) {
  constexpr Doubles kZero = {};
  constexpr double kMax = 1.7976931348623157e308;
  const Floats length = Normalize(v, aim);
  r->index = Masks{} + o.index;
  r->crossed = r->to_wall = Masks{};
  for (int a = 0; a < 3; ++a) {
    const Doubles d = ToDoubles(aim->d[a]);
    const Doubles size = Greater(d, -d);
    const Masks up = d > 0;
    const Masks moves = size > 0;
    const Doubles border = up ? kZero + o.to_border_m[1][a] : kZero - o.to_border_m[0][a];
    const Masks to_wall = up ? Masks{} + o.to_wall[1][a] : Masks{} + o.to_wall[0][a];
    r->t_m[a] = moves ? border / size : kZero + kMax;
    r->dt_m[a] = moves ? o.width_m / size : kZero + kMax;
    r->stride[a] = up ? Masks{} + o.stride[a] : Masks{} - o.stride[a];
    r->to_wall += to_wall << (kField * a);
  }
  return length;
}

/// Segments to ends_W. @returns a bit for each lane that is none: beyond the keys, or of no length
inline unsigned AimExactlyAtEnds(const Origin& o, const float* ends_W, ExactRays* r) {
  Aim aim;
  Floats along[3];
  Counts outside = {};
  Counts moved = {};
  r->to_end = Masks{};
  for (int a = 0; a < 3; ++a) {
    const Floats end = Coordinates(ends_W, a);
    along[a] = end - o.p_W[a];
    const Counts voxel = Voxels(o, end);
    const Counts beyond = (voxel < -kReach) | (voxel >= kReach);
    const Counts off = (beyond ? Counts{} : voxel) - o.voxel[a];
    outside |= beyond;
    moved |= off;
    r->to_end += ToMasks(off < 0 ? -off : off) << (kField * a);
  }
  r->length_m = ToDoubles(AimExactly(o, along, &aim, r));
  const Counts goes = aim.starts & ~outside & (moved != 0);
  r->going = ToMasks(goes);
  return LanesOf(~goes & (outside | (moved != 0)));
}

/// Rays along directions_W of any length > 0, while the crossings are not beyond sure_m. @returns a
/// bit for each lane that is none
inline unsigned AimExactlyAlong(const Origin& o, const float* directions_W, double sure_m,
                                ExactRays* r) {
  Aim aim;
  const Floats along[3] = {Coordinates(directions_W, 0), Coordinates(directions_W, 1),
                           Coordinates(directions_W, 2)};
  AimExactly(o, along, &aim, r);
  r->length_m = Doubles{} + sure_m;
  r->to_end = ~Masks{};  // nowhere
  r->going = ToMasks(aim.starts);
  return LanesOf(~aim.starts);
}

/// One step of each ray, as RayWalk::Next takes it.
inline void StepExactly(ExactRays* r) {
  const Masks x_before_y = r->t_m[0] < r->t_m[1];
  const Masks before_z = Lesser(r->t_m[0], r->t_m[1]) < r->t_m[2];
  const Masks axis[3] = {x_before_y & before_z, ~x_before_y & before_z, ~before_z};
  for (int a = 0; a < 3; ++a) {
    r->t_m[a] = r->t_m[a] + (Doubles)((Masks)r->dt_m[a] & axis[a]);
    r->index += r->stride[a] & axis[a];
    r->crossed += axis[a] & kOneCrossing[a];
  }
  const Doubles next_m = Lesser(Lesser(r->t_m[0], r->t_m[1]), r->t_m[2]);
  r->going &= ~((r->crossed == r->to_end) | (next_m > r->length_m) |
                (((r->to_wall - r->crossed) & kBelow0) != 0));
}

/// Sets the bits of where those rays are that still go. @returns whether any does
inline bool MarkWhere(const ExactRays& r, std::uint32_t* bits) {
  const unsigned going = LanesOf(r.going);
  const Counts index = ToCounts(r.index & r.going);  // those that stopped may be anywhere
  const Counts word = Words(bits, index >> 5);
  const Counts unmarked = ~(word << (~index & 31)) >> 31;
  for (unsigned lanes = LanesOf(unmarked) & going; lanes != 0; lanes &= lanes - 1) {
    const int i = index[__builtin_ctz(lanes)];
    bits[i >> 5] |= 1U << (i & 31);
  }
  return going != 0;
}

/// The triples redo[0] to redo[n - 1] of many, at most kMany of them; what is missing is `fill`.
inline void Collect(const float* triples, const int* redo, int n, const float* fill, float* to) {
  for (int k = 0; k < 3 * kMany; ++k) {
    to[k] = k / 3 < n ? triples[3 * redo[k / 3] + k % 3] : fill[k % 3];
  }
}

/// Keeps those of redo[i], redo[i + 1], ... that have a bit, at redo[kept] and on. @returns how
/// many there are then
inline int Keep(unsigned lanes, int i, int n, int kept, int* redo) {
  for (; lanes != 0; lanes &= lanes - 1) {
    const int at = i + __builtin_ctz(lanes);
    if (at < n) {
      redo[kept++] = redo[at];
    }
  }
  return kept;
}

/// Sets the bit of every voxel of the segments redo[] to ends_W. @returns how many are none; their
/// numbers are left in redo[]
inline int MarkExactly(const Origin& o, const float* ends_W, int n, std::uint32_t* bits,
                       int* redo) {
  int none = 0;
  for (int i = 0; i < n; i += kMany) {
    float ends[3 * kMany];
    Collect(ends_W, redo + i, n - i, o.p_W, ends);
    ExactRays rays[kSides];
    unsigned bad = 0;
    bool going = false;
    for (int s = 0; s < kSides; ++s) {
      bad |= AimExactlyAtEnds(o, ends + 3 * kHalf * s, &rays[s]) << (kHalf * s);
      going |= MarkWhere(rays[s], bits);
    }
    while (going) {
      going = false;
      for (ExactRays& side : rays) {
        StepExactly(&side);
        going |= MarkWhere(side, bits);
      }
    }
    none = Keep(bad, i, n, none, redo);
  }
  return none;
}

/// What kHalf rays saw on their way.
struct ExactSights {
  Masks unknown;
  Masks surface;
  Masks ended;
  Masks crossed;  // up to the last voxel looked at
};

/// Looks at where those rays are that still go, and ends those that it ends. @returns whether any
/// goes on
inline bool LookWhere(const std::uint32_t* codes, bool unknown_ends, ExactRays* r, ExactSights* s) {
  const Counts index = ToCounts(r->index & r->going);
  const Counts word = Words(codes, index >> 4);
  const Counts code = (Counts)((Bits)word >> (Bits)((index & 15) << 1)) & 3;
  const Masks not_known = ToMasks(code < 2) & r->going;
  const Masks hit = ToMasks(code == 3) & r->going;
  const Masks end = unknown_ends ? hit | not_known : hit;
  s->unknown -= not_known;
  s->surface |= hit;
  s->ended |= end;
  s->crossed = r->going ? r->crossed : s->crossed;
  r->going &= ~end;
  return LanesOf(r->going) != 0;
}

inline void Tell(const ExactRays& rays, const ExactSights& s, int l, End* end) {
  constexpr std::int64_t kOneField = (std::int64_t{1} << kField) - 1;
  end->unknown = static_cast<int>(s.unknown[l]);
  end->surface = s.surface[l] != 0;
  end->by_sight = s.ended[l] != 0;
  for (int a = 0; a < 3; ++a) {
    const int off = static_cast<int>((s.crossed[l] >> (kField * a)) & kOneField);
    end->off[a] = rays.stride[a][l] > 0 ? off : -off;
  }
}

/// Follows the rays redo[] that aim(triples, &rays) begins, from beyond the origin's voxel, which
/// adds unknown_here to what each has seen. @returns how many are none; their numbers are left in
/// redo[]
template <typename AimHalf>
inline int LookExactly(const float* triples, const float* fill, int n, const std::uint32_t* codes,
                       bool unknown_ends, int unknown_here, AimHalf aim, End* ends, int* redo) {
  int none = 0;
  for (int i = 0; i < n; i += kMany) {
    float some[3 * kMany];
    Collect(triples, redo + i, n - i, fill, some);
    ExactRays rays[kSides];
    ExactSights sights[kSides] = {};
    unsigned bad = 0;
    for (int s = 0; s < kSides; ++s) {
      sights[s].unknown += unknown_here;
      bad |= aim(some + 3 * kHalf * s, &rays[s]) << (kHalf * s);
    }
    for (bool going = true; going;) {
      going = false;
      for (int s = 0; s < kSides; ++s) {
        StepExactly(&rays[s]);
        going |= LookWhere(codes, unknown_ends, &rays[s], &sights[s]);
      }
    }
    for (int l = 0; l < kMany && i + l < n; ++l) {
      Tell(rays[l / kHalf], sights[l / kHalf], l % kHalf, &ends[redo[i + l]]);
    }
    none = Keep(bad, i, n, none, redo);
  }
  return none;
}

}  // namespace
}  // namespace pipewright::fan::PIPEWRIGHT_FAN_ISA
