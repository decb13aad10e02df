// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>

#include "perception/map/key_math.h"

namespace pipewright {

/// Four rays from one origin, stepped together as RayWalk steps one, to the last bit.
///
/// A step costs no branch: which axis is crossed next becomes a mask (the compiler's generic
/// vectors, so the same source serves SSE2, AVX and NEON). A voxel is its flat index in the box,
/// held as a double like all else. A lane that is done rests on the origin's voxel.
class RayPacket {
 public:
  static constexpr int kLanes = 4;

  /// One value a lane. Two halves of two: the width that every target has.
  template <typename T>
  struct Lanes {
    typedef T Half __attribute__((vector_size(16)));
    Half half[2];
    T operator[](int lane) const { return half[lane >> 1][lane & 1]; }
    void Set(int lane, T value) { half[lane >> 1][lane & 1] = value; }
  };
  using Doubles = Lanes<double>;
  using Masks = Lanes<std::int64_t>;
  using Double2 = Doubles::Half;
  using Mask2 = Masks::Half;

  /// Crossings along each axis, by lane.
  Doubles t_next[3];
  Doubles t_delta[3];
  Doubles stride[3];  ///< in flat indices, signed
  Doubles index;      ///< the voxel that each lane is in
  Doubles end;        ///< stop there: the end's voxel
  Doubles limit;      ///< stop when the next crossing lies farther along the ray
  Masks active;       ///< all ones, or zero: done
  double rest = 0;    ///< the origin's voxel

  /// One voxel further for every active lane. False: all are done.
  bool Step() {
    const Mask2 more = StepHalf(0) | StepHalf(1);
    return (more[0] | more[1]) != 0;
  }

  void Retire(int lane) { active.Set(lane, 0); }

 private:
  static Double2 Pick(Mask2 mask, Double2 yes, Double2 no) {
    return reinterpret_cast<Double2>((mask & reinterpret_cast<Mask2>(yes)) |
                                     (~mask & reinterpret_cast<Mask2>(no)));
  }
  static Double2 Keep(Mask2 mask, Double2 value) {
    return reinterpret_cast<Double2>(mask & reinterpret_cast<Mask2>(value));
  }
  static Double2 Min(Double2 a, Double2 b) { return Pick(a < b, a, b); }

  Mask2 StepHalf(int h) {
    Double2 tx = t_next[0].half[h];
    Double2 ty = t_next[1].half[h];
    Double2 tz = t_next[2].half[h];
    const Mask2 x_before_y = tx < ty;
    const Mask2 before_z = Pick(x_before_y, tx, ty) < tz;
    const Mask2 x = x_before_y & before_z;
    const Mask2 y = ~x_before_y & before_z;
    const Mask2 z = ~before_z;
    tx += Keep(x, t_delta[0].half[h]);
    ty += Keep(y, t_delta[1].half[h]);
    tz += Keep(z, t_delta[2].half[h]);
    t_next[0].half[h] = tx;
    t_next[1].half[h] = ty;
    t_next[2].half[h] = tz;
    const Double2 next =
        index.half[h] + Pick(x, stride[0].half[h], Pick(y, stride[1].half[h], stride[2].half[h]));
    const Double2 nearest = Min(Min(tx, ty), tz);
    const Mask2 going = active.half[h] & (nearest <= limit.half[h]) & (next != end.half[h]);
    active.half[h] = going;
    index.half[h] = Pick(going, next, Double2{rest, rest});
    return going;
  }
};

}  // namespace pipewright
