// SPDX-License-Identifier: MIT
// The body of fan_kernels.h for one instruction set: PIPEWRIGHT_FAN_ISA names its namespace. Only
// for fan_kernels.cc and fan_kernels_avx2.cc.
#include "perception/map/fan_clip_inl.h"
#include "perception/map/fan_table.h"

namespace pipewright::fan::PIPEWRIGHT_FAN_ISA {
namespace {

/// The first n of 8 triples; what is missing lies at the origin.
template <typename Number>
const Number* Eight(const Number* triples, int n, const Number* fill, Number* room) {
  if (n >= kLanes) {
    return triples;
  }
  for (int i = 0; i < 3 * kLanes; ++i) {
    room[i] = i < 3 * n ? triples[i] : fill[i % 3];
  }
  return room;
}

inline unsigned AimAll(const Origin& o, const float* ends_W, Rays* rays) {
  unsigned home = 0;
  for (int from = 0; from < kLanes; from += kHalf) {
    home |= AimAtEnds(o, ends_W + 3 * from, from, rays);
  }
  return home;
}

constexpr unsigned kAllLanes = (1U << kLanes) - 1;

int Mark(const Origin& o, const float* ends_W, int n, std::uint32_t* bits, int* redo) {
  int unsure = 0;
  float room[3 * kLanes];
  Rays rays;
  MarkVisit visit;
  visit.bits = bits;
  for (int i = 0; i < n; i += kLanes) {
    const unsigned home = AimAll(o, Eight(ends_W + 3 * i, n - i, o.p_W, room), &rays);
    for (int from = 0; from < kLanes; from += kWidth) {
      Follow(&rays, from, &visit);
    }
    visit.MarkFresh();
    unsigned goes = 0;
    unsigned sure = home;
    for (int from = 0; from < kLanes; from += kWidth) {
      Ints steps, looked;
      Load(rays.steps + from, &steps);
      Load(rays.looked + from, &looked);
      const Ints some = steps >= 0;  // named: a comparison's own type suits more than one LanesOf
      const Ints all = some & (looked == steps);
      goes |= LanesOf(some) << from;
      sure |= LanesOf(all) << from;
    }
    if (goes != 0) {
      bits[o.index >> 5] |= 1U << (o.index & 31);
    }
    for (unsigned left = ~sure & kAllLanes; left != 0; left &= left - 1) {
      redo[unsure++] = i + __builtin_ctz(left);
    }
  }
  return MarkExactly(o, ends_W, unsure, bits, redo);
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
    const unsigned home = AimAll(o, Eight(ends_W + 3 * i, n - i, o.p_W, room), &rays);
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
  if (in_surface) {
    return unsure;
  }
  const auto aim = [&o](const float* some_W, ExactRays* r) {
    return AimExactlyAtEnds(o, some_W, r);
  };
  return LookExactly(ends_W, o.p_W, unsure, codes, false, origin_code < 2 ? 1 : 0, aim, ends, redo);
}

int Cast(const Origin& o, const float* directions_W, int n, double sure_m, bool unknown_ends,
         const std::uint32_t* codes, End* ends, int* redo) {
  int unsure = 0;
  float room[3 * kLanes];
  Rays rays;
  Sights sights;
  const float nowhere[3] = {0, 0, 0};
  for (int i = 0; i < n; i += kLanes) {
    const float* const along_W = Eight(directions_W + 3 * i, n - i, nowhere, room);
    for (int from = 0; from < kLanes; from += kHalf) {
      AimAlong(o, along_W + 3 * from, sure_m, from, &rays);
    }
    Look(codes, unknown_ends, &rays, &sights);
    for (int l = 0; l < kLanes && i + l < n; ++l) {
      Tell(rays, sights, l, &ends[i + l]);
      redo[unsure] = i + l;
      unsure += sights.sure[l] != 0 ? 0 : 1;
    }
  }
  const auto aim = [&o, sure_m](const float* some_W, ExactRays* r) {
    return AimExactlyAlong(o, some_W, sure_m, r);
  };
  return LookExactly(directions_W, nowhere, unsure, codes, unknown_ends, 0, aim, ends, redo);
}

int Gather(const CellOrigin& o, const double* directions, int n, double length, Search* search,
           int* redo) {
  const unsigned code = (search->codes[o.index >> 4] >> ((o.index & 15) * 2)) & 3U;
  const int here = code < 2 ? 1 : 0;
  if (here != 0) {
    SearchVisit::Take(o.index, search);
  }
  if ((code & 1U) != 0) {
    search->wanted += here * n;
    return 0;
  }
  int unsure = 0;
  double room[3 * kLanes];
  const double nowhere[3] = {0, 0, 0};
  Rays rays;
  alignas(32) std::int32_t wanted[kLanes];
  alignas(32) std::int32_t ended[kLanes];
  for (int i = 0; i < n; i += kLanes) {
    const double* const eight = Eight(directions + 3 * i, n - i, nowhere, room);
    for (int from = 0; from < kLanes; from += kHalf) {
      AimInCells(o, eight + 3 * from, length, from, &rays);
    }
    for (int from = 0; from < kLanes; from += kWidth) {
      SearchVisit visit{search};
      Follow(&rays, from, &visit);
      Store(visit.wanted, wanted + from);
      Store(visit.ended, ended + from);
    }
    for (int l = 0; l < kLanes && i + l < n; ++l) {
      const bool sure = rays.steps[l] >= 0 && (ended[l] != 0 || rays.looked[l] == rays.steps[l]);
      search->wanted += sure ? here + wanted[l] : 0;
      redo[unsure] = i + l;
      unsure += sure ? 0 : 1;
    }
  }
  return unsure;
}

int FindBlocked(const CellOrigin& o, const double* directions, int n, double length,
                const std::uint32_t* codes, std::uint8_t* blocked, int* redo) {
  const bool in_surface = ((codes[o.index >> 4] >> ((o.index & 15) * 2)) & 3U) == 3;
  int unsure = 0;
  double room[3 * kLanes];
  const double nowhere[3] = {0, 0, 0};
  Rays rays;
  Sights sights;
  for (int i = 0; i < n; i += kLanes) {
    const double* const eight = Eight(directions + 3 * i, n - i, nowhere, room);
    for (int from = 0; from < kLanes; from += kHalf) {
      AimInCells(o, eight + 3 * from, length, from, &rays);
    }
    Look(codes, false, &rays, &sights);
    for (int l = 0; l < kLanes && i + l < n; ++l) {
      blocked[i + l] = in_surface || sights.surface[l] != 0 ? 1 : 0;
      redo[unsure] = i + l;
      unsure += in_surface || sights.sure[l] != 0 ? 0 : 1;
    }
  }
  return unsure;
}

void Cells(const Origin& o, const float* points_W, int n, std::int32_t* hit_index) {
  constexpr int kAhead = 1024;  // floats, a page: where the machine's own foresight ends
  const CellFinder finder(o);
  int i = 0;
  for (; i + kHalf <= n; i += kHalf) {
    __builtin_prefetch(points_W + 3 * i + kAhead);
    Store(finder.Find(points_W + 3 * i), hit_index + i);
  }
  float room[3 * kLanes];
  for (; i < n; i += kHalf) {
    const Counts index = finder.Find(Eight(points_W + 3 * i, n - i, o.p_W, room));
    for (int l = 0; l < kHalf && i + l < n; ++l) {
      hit_index[i + l] = index[l];
    }
  }
}

void Clip(const Origin& o, const float* points_W, int n, double max_range_m, float* ends_W,
          std::int32_t* hit_index) {
  PIPEWRIGHT_FAN_ISA::Cells(o, points_W, n, hit_index);
  if (max_range_m < 0) {
    __builtin_memcpy(ends_W, points_W, sizeof(float) * 3 * static_cast<unsigned>(n));
    return;
  }
  float room[3 * kLanes];
  for (int i = 0; i < n; i += kHalf) {
    float end[3 * kHalf];
    const Counts clipped =
        ClipHalf(o, Eight(points_W + 3 * i, n - i, o.p_W, room), max_range_m, end);
    const int count = n - i < kHalf ? n - i : kHalf;
    for (int l = 0; l < count; ++l) {
      hit_index[i + l] |= clipped[l];
    }
    for (int k = 0; k < 3 * count; ++k) {
      ends_W[3 * i + k] = end[k];
    }
  }
}

}  // namespace

constinit const Table kTable{.clip = Clip,
                             .cells = Cells,
                             .mark = Mark,
                             .trace = Trace,
                             .cast = Cast,
                             .gather = Gather,
                             .find_blocked = FindBlocked};

}  // namespace pipewright::fan::PIPEWRIGHT_FAN_ISA
