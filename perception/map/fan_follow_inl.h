// SPDX-License-Identifier: MIT
// Only for fan_kernels_inl.h: the walk of eight rays, and what they do on their way.
#include "perception/map/fan_aim_inl.h"

namespace pipewright::fan::PIPEWRIGHT_FAN_ISA {
namespace {

/// Steps kWidth rays until all have ended. Every step calls visit(index, going, &ended): a lane
/// that it ends counts no further, but is stepped on, so that no step waits for what the one before
/// it saw. If the visit wants no tie, a lane ends, unseen, where it cannot be told which of two
/// voxels comes first. Else the voxel after a tie may be a wrong one, when a third crossing lies
/// near the second, and only the count of steps tells.
template <typename Visit>
inline void Follow(Rays* r, int from, Visit* visit) {
  Ints tx, ty, tz, dx, dy, dz, sx, sy, sz, slack, horizon, index;
  Load(r->first[0] + from, &tx);
  Load(r->first[1] + from, &ty);
  Load(r->first[2] + from, &tz);
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
  Ints ended = {};
  Ints reached = Ints{} - 1;  // below every crossing
  for (;;) {
    const Ints nearest = Smaller(Smaller(tx, ty), tz);
    const Ints within = nearest <= horizon;
    Ints going = within & ~ended;
    if (LanesOf(going) == 0) {
      break;
    }
    // What is no farther than the slack is crossed at once: then there are fewer steps than
    // crossings in the end, and that tells.
    const Ints reach = (nearest + slack) | ~within;  // -1: below every crossing
    const Ints x = tx <= reach;
    const Ints y = ty <= reach;
    const Ints z = tz <= reach;
    tx += dx & x;
    ty += dy & y;
    tz += dz & z;
    index += (sx & x) + (sy & y) + (sz & z);
    if constexpr (Visit::kTiesEnd) {
      ended |= x + y + z < -1;
      going = within & ~ended;
    } else {
      reached = going ? reach : reached;
    }
    looked -= going;
    visit->See(index, going, &ended);
  }
  Store(reached, r->reached + from);
  Store(looked, r->looked + from);
}

/// Sets bits. Those that are not set yet are listed first and set together: whether a voxel is new
/// is what a branch could not foresee.
struct MarkVisit {
  static constexpr bool kTiesEnd = true;  // a bit once set stays set
  static constexpr int kRoom = 1024;
  std::uint32_t* bits;
  int fresh = 0;
  std::int32_t list[kRoom];

  void See(const Ints& index, const Ints& going, Ints*) {
    const Ints word = Words(bits, index >> 5);
    const Ints unmarked = ~(word << (~index & 31)) >> 31;
    fresh += Pack(index, LanesOf(unmarked & going), list + fresh);
    if (fresh > kRoom - kWidth) {
      MarkFresh();
    }
  }

  void MarkFresh() {
    for (int i = 0; i < fresh; ++i) {
      bits[list[i] >> 5] |= 1U << (list[i] & 31);
    }
    fresh = 0;
  }
};

/// Two bits of each voxel.
inline Ints CodesAt(const std::uint32_t* codes, const Ints& index) {
  typedef std::uint32_t Words32 __attribute__((vector_size(sizeof(Ints))));
  const Ints word = Words(codes, index >> 4);
  return (Ints)((Words32)word >> (Words32)((index & 15) << 1)) & 3;
}

/// What a ray sees in two bits a voxel.
struct LookVisit {
  static constexpr bool kTiesEnd = false;
  const std::uint32_t* codes;
  bool unknown_ends;
  Ints unknown = {};
  Ints surface = {};
  Ints ended = {};

  void See(const Ints& index, const Ints& going, Ints* stopped) {
    const Ints code = CodesAt(codes, index);
    const Ints not_known = (code < 2) & going;
    const Ints hit = (code == 3) & going;
    unknown -= not_known;
    surface |= hit;
    const Ints end = unknown_ends ? hit | not_known : hit;
    ended |= end;
    *stopped |= end;
  }
};

/// Where the rays stopped, and whether they saw a voxel after every crossing. `ended`: by what they
/// saw, not by their length.
inline void FindEnds(const Rays& r, const std::int32_t* ended, std::int32_t* sure,
                     std::int32_t (*off)[kLanes]) {
  std::int32_t crossings[kLanes] = {};
  for (int a = 0; a < 3; ++a) {
    for (int l = 0; l < kLanes; ++l) {
      // Of the crossings first + k dt those up to where the ray has come.
      const double after_first = static_cast<double>(r.reached[l] - r.first[a][l]) / r.dt[a][l];
      off[a][l] = r.reached[l] < r.first[a][l] ? 0 : static_cast<std::int32_t>(after_first) + 1;
      crossings[l] += off[a][l];
    }
  }
  for (int l = 0; l < kLanes; ++l) {
    const bool whole = ended[l] != 0 || r.looked[l] == r.steps[l];
    sure[l] = r.steps[l] >= 0 && crossings[l] == r.looked[l] && whole ? 1 : 0;
  }
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
    end->off[a] = rays.stride[a][l] > 0 ? s.off[a][l] : -s.off[a][l];
  }
}

}  // namespace
}  // namespace pipewright::fan::PIPEWRIGHT_FAN_ISA
