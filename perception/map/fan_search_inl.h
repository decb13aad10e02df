// SPDX-License-Identifier: MIT
// Only for fan_kernels_inl.h: rays in double, in cells, and what they find.
#include "perception/map/fan_follow_inl.h"

namespace pipewright::fan::PIPEWRIGHT_FAN_ISA {
namespace {

inline Doubles Components(const double* vectors, int axis) {
#if defined(__AVX2__)
  return Doubles{vectors[axis], vectors[3 + axis], vectors[6 + axis], vectors[9 + axis]};
#else
  return Doubles{vectors[axis], vectors[3 + axis]};
#endif
}

/// kHalf rays {origin + t d, 0 <= t <= length}, the last cell included, or until the box ends.
/// Everything named _m is in cells.
inline void AimInCells(const CellOrigin& o, const double* directions, double length, int from,
                       Rays* r) {
  constexpr double kJustBeyond = 1e-3;  // of the way from one crossing to the next
  constexpr Doubles kZero = {};
  constexpr Counts kNone = {};
  Aim aim;
  Doubles wall = kZero + kNever;
  Doubles finite = kZero;
  for (int a = 0; a < 3; ++a) {
    const Doubles d = Components(directions, a);
    const Doubles inverse = 1 / Greater(d, -d);
    const Masks up = d > 0;
    const Doubles border = up ? kZero + o.to_border[1][a] : kZero + o.to_border[0][a];
    aim.up[a] = __builtin_convertvector(up, Counts);
    aim.t0_m[a] = Greater(Lesser(border * inverse, kZero + kNever), kZero);
    aim.dt_m[a] = Lesser(inverse, kZero + kNever);
    const Counts to_wall = aim.up[a] ? kNone + o.to_wall[1][a] : kNone + o.to_wall[0][a];
    wall = Lesser(aim.t0_m[a] + ToDoubles(to_wall) * aim.dt_m[a], wall);
    finite += d * 0;
  }
  const Masks bounded = wall <= length;
  const Doubles bound = bounded ? wall : kZero + length;
  aim.scale = kTicks / bound;
  for (int a = 0; a < 3; ++a) {
    const Doubles made = (bound - aim.t0_m[a]) / aim.dt_m[a] + 1;
    const Doubles crossings = made + (bounded ? kZero + kJustBeyond : kZero);
    aim.count[a] = ToCounts(Greater(Lesser(crossings, kZero + 1e6), kZero));
  }
  const Timing t = StoreCrossings(o.stride, aim, from, r);
  // At a wall the last crossing leads out; else the ray ends clearly between two crossings.
  const Masks at_wall = bounded & (t.next - t.last > 2 * t.slack + 2) &
                        (t.last > kTicks - t.slack) & (t.last < kTicks + t.slack);
  const Masks by_length = ~bounded & (t.last < kTicks - t.slack) & (t.next > kTicks + t.slack);
  const Masks goes = (at_wall | by_length) & (finite == 0);
  const Doubles steps = bounded ? t.crossings - 1 : t.crossings;
  const Doubles horizon = bounded ? t.last - 3 * t.slack - 1 : kZero + kTicks;
  StoreEnds(goes, steps, horizon, t.slack, o.index, from, r);
}

/// Takes the wanted cells on the way, each once.
struct SearchVisit {
  static constexpr bool kTiesEnd = true;
  Search* search;
  Ints wanted = {};
  Ints ended = {};

  void See(const Ints& index, const Ints& going, Ints* stopped) {
    const Ints code = CodesAt(search->codes, index);
    const Ints here = (code < 2) & going;
    const Ints stop = ((code & 1) != 0) & going;
    wanted -= here;
    ended |= stop;
    *stopped |= stop;
    const Ints word = Words(search->marks, index >> 5);
    const Ints unmarked = ~(word << (~index & 31)) >> 31;
    for (unsigned lanes = LanesOf(unmarked & here); lanes != 0; lanes &= lanes - 1) {
      Take(index[__builtin_ctz(lanes)], search);
    }
  }

  static void Take(int index, Search* s) {
    std::uint32_t& word = s->marks[index >> 5];
    const std::uint32_t bit = 1U << (index & 31);
    if ((word & bit) == 0) {
      word |= bit;
      s->found[s->found_count++] = index;
    }
  }
};

}  // namespace
}  // namespace pipewright::fan::PIPEWRIGHT_FAN_ISA
