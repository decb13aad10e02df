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

/// Segments to ends_W. @returns a bit for each lane that is none: beyond the keys, or of no length
inline unsigned AimExactly(const Origin& o, const float* ends_W, ExactRays* r) {
  constexpr Doubles kZero = {};
  constexpr double kMax = 1.7976931348623157e308;
  Aim aim;
  Floats end[3];
  Floats along[3];
  for (int a = 0; a < 3; ++a) {
    end[a] = Coordinates(ends_W, a);
    along[a] = end[a] - o.p_W[a];
  }
  r->length_m = ToDoubles(Normalize(along, &aim));
  r->index = Masks{} + o.index;
  r->crossed = r->to_end = r->to_wall = Masks{};
  Counts outside = {};
  Counts moved = {};
  for (int a = 0; a < 3; ++a) {
    const Doubles d = ToDoubles(aim.d[a]);
    const Doubles size = Greater(d, -d);
    const Masks up = d > 0;
    const Masks moves = size > 0;
    const Doubles border = up ? kZero + o.to_border_m[1][a] : kZero - o.to_border_m[0][a];
    r->t_m[a] = moves ? border / size : kZero + kMax;
    r->dt_m[a] = moves ? o.width_m / size : kZero + kMax;
    r->stride[a] = up ? Masks{} + o.stride[a] : Masks{} - o.stride[a];
    const Counts voxel = Voxels(o, end[a]);
    const Counts beyond = (voxel < -kReach) | (voxel >= kReach);
    const Counts off = (beyond ? Counts{} : voxel) - o.voxel[a];
    outside |= beyond;
    moved |= off;
    const Masks to_wall = up ? Masks{} + o.to_wall[1][a] : Masks{} + o.to_wall[0][a];
    r->to_end += ToMasks(off < 0 ? -off : off) << (kField * a);
    r->to_wall += to_wall << (kField * a);
  }
  const Counts goes = aim.starts & ~outside & (moved != 0);
  r->going = ToMasks(goes);
  return LanesOf(~goes & (outside | (moved != 0)));
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

/// Sets the bit of every voxel of the segments redo[] of ends_W. @returns how many are none; their
/// numbers are left in redo[]
inline int MarkExactly(const Origin& o, const float* ends_W, int n, std::uint32_t* bits,
                       int* redo) {
  constexpr int kSides = 2;  // at a time: while one waits for a sum, the other goes on
  constexpr int kMany = kSides * kHalf;
  int none = 0;
  for (int i = 0; i < n; i += kMany) {
    float ends[3 * kMany];
    for (int k = 0; k < 3 * kMany; ++k) {
      ends[k] = i + k / 3 < n ? ends_W[3 * redo[i + k / 3] + k % 3] : o.p_W[k % 3];
    }
    ExactRays rays[kSides];
    unsigned bad = 0;
    bool going = false;
    for (int s = 0; s < kSides; ++s) {
      bad |= AimExactly(o, ends + 3 * kHalf * s, &rays[s]) << (kHalf * s);
      going |= MarkWhere(rays[s], bits);
    }
    while (going) {
      going = false;
      for (ExactRays& side : rays) {
        StepExactly(&side);
        going |= MarkWhere(side, bits);
      }
    }
    for (; bad != 0; bad &= bad - 1) {
      redo[none++] = redo[i + __builtin_ctz(bad)];
    }
  }
  return none;
}

}  // namespace
}  // namespace pipewright::fan::PIPEWRIGHT_FAN_ISA
