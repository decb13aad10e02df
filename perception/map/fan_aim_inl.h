// SPDX-License-Identifier: MIT
// Only for fan_kernels_inl.h: eight rays from their ends or directions to crossings in ticks.
#include "perception/map/fan_kernels.h"
#include "perception/map/fan_lanes_inl.h"

namespace pipewright::fan::PIPEWRIGHT_FAN_ISA {
namespace {

constexpr double kTicks = 1 << 29;  // of a ray's whole length
constexpr double kNever = 1e30;     // metres
constexpr double kFar = 1 << 30;    // ticks; one crossing more is below 2^31
constexpr float kFloatMax = 3.4028234663852886e38F;
constexpr int kReach = 1 << 15;  // of OctoMap's keys

/// Eight rays on their way.
struct Rays {
  alignas(32) std::int32_t first[3][kLanes];   // ticks to the first crossing
  alignas(32) std::int32_t dt[3][kLanes];      // from one to the next
  alignas(32) std::int32_t stride[3][kLanes];  // of the index, with the direction's sign
  alignas(32) std::int32_t slack[kLanes];    // crossings nearer to one another may be out of order
  alignas(32) std::int32_t horizon[kLanes];  // no crossing beyond
  alignas(32) std::int32_t steps[kLanes];    // crossings before it; -1: cannot be told for sure
  alignas(32) std::int32_t index[kLanes];
  alignas(32) std::int32_t looked[kLanes];   // steps taken, one voxel each
  alignas(32) std::int32_t reached[kLanes];  // ticks: every crossing up to here is made, no other
};

/// kHalf of them before that. Masks are all ones or 0.
struct Aim {
  Floats d[3];      // direction
  Doubles scale;    // ticks a metre
  Doubles t0_m[3];  // to the first crossing
  Doubles dt_m[3];  // from one crossing to the next
  Counts up[3];     // towards larger indices
  Counts count[3];  // crossings until the end
  Counts starts;    // the ray is one, and leaves the origin's voxel
  Counts bounded;   // it ends where the box or the sure length does, not by itself
};

/// To unit length, rounded as OctoMap rounds. @returns the length
inline Floats Normalize(const Floats* v, Aim* aim) {
  const Floats squared = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  const Floats length = SquareRoot(squared);
  for (int a = 0; a < 3; ++a) {
    aim->d[a] = v[a] / length;
  }
  aim->starts = (length > 0) & (length <= kFloatMax);
  return length;
}

/// The distance along each ray to its crossings.
inline void FindCrossings(const Origin& o, Aim* aim) {
  constexpr Doubles kZero = {};
  for (int a = 0; a < 3; ++a) {
    const Doubles d = ToDoubles(aim->d[a]);
    const Doubles inverse = 1 / Greater(d, -d);
    const Doubles border = d > 0 ? kZero + o.to_border_m[1][a] : kZero - o.to_border_m[0][a];
    aim->up[a] = aim->d[a] > 0;
    aim->t0_m[a] = Lesser(border * inverse, kZero + kNever);
    aim->dt_m[a] = Lesser(o.width_m * inverse, kZero + kNever);
  }
}

inline Counts CellsToWall(const Origin& o, const Aim& aim, int axis) {
  constexpr Counts kZero = {};
  return aim.up[axis] ? kZero + o.to_wall[1][axis] : kZero + o.to_wall[0][axis];
}

/// How far along each ray the box ends.
inline Doubles FindWall(const Origin& o, const Aim& aim) {
  Doubles wall_m = Doubles{} + kNever;
  for (int a = 0; a < 3; ++a) {
    wall_m = Lesser(aim.t0_m[a] + ToDoubles(CellsToWall(o, aim, a)) * aim.dt_m[a], wall_m);
  }
  return wall_m;
}

/// Ends the bounded rays after the crossings up to bound_m.
inline void CountCrossings(const Doubles& bound_m, Aim* aim) {
  constexpr double kJustBeyond = 1e-3;  // of the way from one crossing to the next
  constexpr Doubles kZero = {};
  for (int a = 0; a < 3; ++a) {
    const Doubles crossings = (bound_m - aim->t0_m[a]) / aim->dt_m[a] + (1 + kJustBeyond);
    const Counts count = ToCounts(Greater(Lesser(crossings, kZero + 1e6), kZero));
    aim->count[a] = aim->bounded ? count : aim->count[a];
  }
}

/// Of each ray, in ticks.
struct Timing {
  Doubles crossings;
  Doubles slack;
  Doubles last;  // crossing
  Doubles next;  // and the one after it
};

/// All crossings in ticks.
inline Timing StoreCrossings(const int* stride, const Aim& aim, int from, Rays* r) {
  constexpr Doubles kZero = {};
  constexpr Counts kNone = {};
  Timing timing;
  timing.crossings = ToDoubles(aim.count[0] + aim.count[1] + aim.count[2]);
  timing.last = kZero - 1;
  timing.next = kZero + 1e300;
  Doubles least_t0 = kZero;
  Doubles least_dt = kZero + kTicks;
  for (int a = 0; a < 3; ++a) {
    const Doubles t0 = aim.t0_m[a] * aim.scale;
    const Doubles dt = aim.dt_m[a] * aim.scale;
    const Doubles end = t0 + (ToDoubles(aim.count[a]) - 1) * dt;  // not above 0 where count is 0
    timing.last = Greater(end, timing.last);
    timing.next = Lesser(end + dt, timing.next);
    least_t0 = Lesser(t0, least_t0);
    least_dt = Lesser(dt, least_dt);
    const Counts first = ToCounts(Greater(Lesser(t0, kZero + kFar), kZero) + 0.5);
    Store(first, r->first[a] + from);
    Store(ToCounts(Lesser(dt, kZero + kFar) + 0.5), r->dt[a] + from);
    Store(aim.up[a] ? kNone + stride[a] : kNone - stride[a], r->stride[a] + from);
  }
  // Half a tick a crossing, one for the first, and something. From a border a ray's first crossings
  // may lie behind it, by the rounding of half a width. No ray goes whose steps are of few ticks.
  timing.slack = 0.5 * timing.crossings + 4 - 2 * least_t0;
  timing.slack = least_dt > 16 ? timing.slack : kZero + kTicks;
  return timing;
}

/// Where the rays end; what cannot be told for sure gets no steps.
inline void StoreEnds(const Masks& goes, const Doubles& steps, const Doubles& horizon,
                      const Doubles& slack, int index, int from, Rays* r) {
  constexpr Doubles kZero = {};
  Store(ToCounts(goes ? steps : kZero - 1), r->steps + from);
  Store(ToCounts(goes ? horizon : kZero - 1), r->horizon + from);
  Store(ToCounts(Lesser(slack, kZero + 1e6)), r->slack + from);
  Store(Counts{} + index, r->index + from);
}

/// The crossing before the last, in ticks; -1: there is none.
inline Doubles LastButOne(const Aim& aim) {
  constexpr Doubles kZero = {};
  Doubles last = kZero - 1;
  Doubles before = kZero - 1;
  for (int a = 0; a < 3; ++a) {
    const Doubles count = ToDoubles(aim.count[a]);
    const Doubles dt = aim.dt_m[a] * aim.scale;
    const Doubles end = aim.t0_m[a] * aim.scale + (count - 1) * dt;
    const Doubles its_last = count > 0 ? end : kZero - 1;
    before = Greater(before, Lesser(last, its_last));
    before = Greater(before, count > 1 ? end - dt : kZero - 1);
    last = Greater(last, its_last);
  }
  return before;
}

/// Where a segment's last crossing lies beyond its end, by what float makes of its direction and
/// length, computeRayKeys leaves out the voxel before that crossing too. So it is with about half
/// of all readings of a wall that stands on a border of voxels.
inline void EndBefore(const Masks& beyond, const Doubles& before, Timing* t) {
  constexpr Doubles kZero = {};
  t->crossings = beyond ? Greater(t->crossings - 1, kZero + 1) : t->crossings;
  t->last = beyond ? before : t->last;
}

inline void Schedule(const Origin& o, const Doubles& bound_m, const Aim& aim, int from, Rays* r) {
  constexpr Doubles kZero = {};
  Timing t = StoreCrossings(o.stride, aim, from, r);
  const Masks bounded = ToMasks(aim.bounded);
  const Doubles end = bounded ? bound_m * aim.scale : kZero + kTicks;
  const Masks apart = t.next - t.last > 2 * t.slack + 2;
  const Masks at_bound = (t.last < end + t.slack) & (end < kTicks * (1 + 1e-9));
  // On which side of a ray's own end its last crossing lies is told in doubles: there the sums of
  // computeRayKeys are off by less than 2^-24 ticks for each crossing.
  const Doubles rounding = 1e-6 * t.crossings + 1e-5;
  const Masks beyond = ~bounded & (t.last > end);
  Masks by_itself = t.last < end - rounding;
  if (LanesOf(beyond) != 0) {
    const Doubles before = LastButOne(aim);
    by_itself |= beyond & (t.last > end + rounding) & (before < end - rounding);
    EndBefore(beyond, before, &t);
  }
  const Masks goes = apart & ((bounded & at_bound) | (~bounded & by_itself)) & (t.crossings > 0) &
                     ToMasks(aim.starts);
  // Well before the last crossing: what lies between is as good as a tie with it.
  StoreEnds(goes, t.crossings - 1, t.last - 3 * t.slack - 1, t.slack, o.index, from, r);
}

/// Far outside of every box for a coordinate that is beyond the keys by much, or no number.
inline Counts Voxels(const Origin& o, const Floats& coordinate) {
  return Floor(o.width_inv * ToDoubles(coordinate));
}

/// Segments to ends_W as OctoMap's computeRayKeys begins them. @returns a bit for each lane that
/// has nothing to pass: its end lies in the origin's voxel
inline unsigned AimAtEnds(const Origin& o, const float* ends_W, int from, Rays* r) {
  Aim aim;
  Floats end[3];
  Floats along[3];
  for (int a = 0; a < 3; ++a) {
    end[a] = Coordinates(ends_W, a);
    along[a] = end[a] - o.p_W[a];
  }
  const Floats length = Normalize(along, &aim);
  aim.scale = kTicks / ToDoubles(length);
  FindCrossings(o, &aim);
  Counts outside = {};
  Counts moved = {};
  aim.bounded = Counts{};
  for (int a = 0; a < 3; ++a) {
    const Counts voxel = Voxels(o, end[a]);
    outside |= (voxel < -kReach) | (voxel >= kReach);
    const Counts off = (outside ? Counts{} : voxel) - o.voxel[a];
    aim.count[a] = off < 0 ? -off : off;
    moved |= off;
    aim.bounded |= aim.count[a] > CellsToWall(o, aim, a);
  }
  aim.starts &= ~outside;
  Doubles wall_m = {};
  if (LanesOf(aim.bounded) != 0) {
    wall_m = FindWall(o, aim);
    CountCrossings(wall_m, &aim);
    // Not if too near to the end to tell which comes first.
    const Doubles slack = 0.5 * ToDoubles(aim.count[0] + aim.count[1] + aim.count[2]) + 8;
    const Masks early = wall_m * aim.scale < kTicks - slack;
    aim.starts &= ~aim.bounded | __builtin_convertvector(early, Counts);
  }
  Schedule(o, wall_m, aim, from, r);
  return LanesOf((moved == 0) & ~outside) << from;
}

/// Rays of any length > 0 as OctoMap's castRay begins them, until the box or sure_m ends.
inline void AimAlong(const Origin& o, const float* directions_W, double sure_m, int from, Rays* r) {
  Aim aim;
  const Floats along[3] = {Coordinates(directions_W, 0), Coordinates(directions_W, 1),
                           Coordinates(directions_W, 2)};
  Normalize(along, &aim);
  aim.bounded = ~Counts{};
  FindCrossings(o, &aim);
  const Doubles bound_m = Lesser(FindWall(o, aim), Doubles{} + sure_m);
  aim.scale = kTicks / bound_m;
  CountCrossings(bound_m, &aim);
  Schedule(o, bound_m, aim, from, r);
}

}  // namespace
}  // namespace pipewright::fan::PIPEWRIGHT_FAN_ISA
