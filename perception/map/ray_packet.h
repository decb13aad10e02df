// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>

#include "perception/map/key_math.h"

namespace pipewright {

/// Four rays from one origin, stepped together as RayWalk steps one, to the last bit.
///
/// A step costs no branch: which axis is crossed next becomes a mask (the compiler's generic
/// vectors, so the same source serves SSE2, AVX and NEON). A voxel is its flat index less that of
/// the origin's voxel, held as a double like all else. A lane that is done rests at the origin: 0.
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
  using Double2 = Doubles::Half;
  typedef std::int32_t Bits __attribute__((vector_size(16)));

  /// Crossings along each axis, by lane.
  Doubles t_next[3];
  Doubles t_delta[3];
  Doubles stride[3];  ///< in flat indices, signed
  Doubles index;      ///< the voxel that each lane is in, less the origin's
  Doubles end;        ///< stop there: the end's voxel, less the origin's
  Doubles limit;      ///< stop when the next crossing lies farther along the ray; kDone: done

  static constexpr double kDone = -std::numeric_limits<double>::max();

  /// One voxel further for every lane that is not done. False: all are.
  bool Step() {
    const Bits going = StepHalf(0) | StepHalf(1);
    return (going[0] | going[2]) != 0;
  }

 private:
  // GCC 12 takes 64-bit masks apart into scalars on SSE2; of 32-bit ones it keeps its hands off.
  static Bits Less(Double2 a, Double2 b) { return reinterpret_cast<Bits>(a < b); }
  static Bits AtMost(Double2 a, Double2 b) { return reinterpret_cast<Bits>(a <= b); }
  static Double2 Keep(Bits mask, Double2 value) {
    return reinterpret_cast<Double2>(mask & reinterpret_cast<Bits>(value));
  }
  static Double2 Drop(Bits mask, Double2 value) {
    return reinterpret_cast<Double2>(~mask & reinterpret_cast<Bits>(value));
  }

  Bits StepHalf(int h) {
    Double2 tx = t_next[0].half[h];
    Double2 ty = t_next[1].half[h];
    Double2 tz = t_next[2].half[h];
    // OctoMap's choice of the nearest crossing, ties included, from three independent comparisons:
    // the way from one crossing to the next is what a step waits for.
    const Bits x_before_y = Less(tx, ty);
    const Bits x = x_before_y & Less(tx, tz);
    const Bits y = ~x_before_y & Less(ty, tz);
    const Bits not_z = x | y;
    tx += Keep(x, t_delta[0].half[h]);
    ty += Keep(y, t_delta[1].half[h]);
    tz += Drop(not_z, t_delta[2].half[h]);
    t_next[0].half[h] = tx;
    t_next[1].half[h] = ty;
    t_next[2].half[h] = tz;
    // The three addends are exact and at most one is not zero.
    const Double2 next = index.half[h] + (Keep(x, stride[0].half[h]) + Keep(y, stride[1].half[h]) +
                                          Drop(not_z, stride[2].half[h]));
    // A lane at its end is done from now on. One beyond its limit stays so: crossings only grow.
    const Bits at_end = reinterpret_cast<Bits>(next == end.half[h]);
    limit.half[h] = Drop(at_end, limit.half[h]) + Keep(at_end, Double2{kDone, kDone});
    const Bits going = AtMost(tx, limit.half[h]) | AtMost(ty, limit.half[h]) |  //
                       AtMost(tz, limit.half[h]);
    index.half[h] = Keep(going, next);
    return going;
  }
};

}  // namespace pipewright
