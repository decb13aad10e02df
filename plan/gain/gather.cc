// SPDX-License-Identifier: MIT
// The rays of one origin side by side.
#include <algorithm>
#include <array>
#include <cmath>

#include "plan/gain/cells.h"

namespace pipewright {

void GainEvaluator::Cells::LayPlanes() {
  constexpr int kCodes = 16;  // a word
  std::array<std::array<std::uint8_t, 256>, 3> code{};
  constexpr Flag kWanted[] = {kUnknown, kUncovered, kRoom};
  for (int p = 0; p < 3; ++p) {
    for (int here = 0; here < 256; ++here) {
      const int none = (here & kWanted[p]) != 0 ? 0 : 2;
      code[p][here] = static_cast<std::uint8_t>(none | ((here & (kOccupied | kBorder)) != 0));
    }
  }
  const auto cells = static_cast<int>(flags.size());
  for (int first = 0; first < cells; first += kCodes) {
    std::uint32_t words[3] = {0, 0, 0};
    for (int i = 0; i < std::min(kCodes, cells - first); ++i) {
      for (int p = 0; p < 3; ++p) {
        words[p] |= std::uint32_t{code[p][flags[first + i]]} << 2 * i;
      }
    }
    for (int p = 0; p < 3; ++p) {
      PlaneOf(kWanted[p])[first / kCodes] = words[p];
    }
  }
}

void GainEvaluator::Cells::Forget() {
  for (int i = 0; i < taken_count; ++i) {
    marks[taken[i] >> 5] = 0;
  }
  taken_count = 0;
  if (++stamp == 0) {
    std::fill(probe_stamps.begin(), probe_stamps.end(), 0U);
    stamp = 1;
  }
}

void GainEvaluator::Cells::Take(int cell) {
  const std::uint32_t bit = 1U << (cell & 31);
  if ((marks[cell >> 5] & bit) == 0) {
    marks[cell >> 5] |= bit;
    taken[taken_count++] = cell;
  }
}

int GainEvaluator::Cells::Turn(const Isometry3d& X_WS, const RaySet& rays) {
  int n = 0;
  for (const Vector3d& direction : rays.directions) {
    directions[n++] = X_WS.linear() * direction;
  }
  return n;
}

// Rays that begin within W may end with it: they do not come back.
fan::CellOrigin GainEvaluator::Cells::AimFrom(const Vector3d& origin, bool within_workspace) const {
  const int stride[3] = {1, nx, nx * ny};
  const int lo[3] = {map.lo.x, map.lo.y, map.lo.z};
  const int size[3] = {nx, ny, nz};
  const int w_lo[3] = {map.workspace_lo.x, map.workspace_lo.y, map.workspace_lo.z};
  const int w_hi[3] = {map.workspace_hi.x, map.workspace_hi.y, map.workspace_hi.z};
  fan::CellOrigin from{};
  for (int a = 0; a < 3; ++a) {
    const double floor = std::floor(origin[a]);
    const auto at = static_cast<int>(floor);
    from.to_border[0][a] = origin[a] - floor;
    from.to_border[1][a] = floor + 1 - origin[a];
    from.to_wall[0][a] = at - (within_workspace ? w_lo[a] - lo[a] + 1 : 1);
    from.to_wall[1][a] = (within_workspace ? w_hi[a] - lo[a] + 1 : size[a] - 2) - at;
    from.stride[a] = stride[a];
    from.index += stride[a] * at;
  }
  return from;
}

int GainEvaluator::Cells::Gather(const Vector3d& origin, int n, double length, Flag wanted,
                                 GainCount count) {
  if (n == 0) {
    return 0;
  }
  fan::CellOrigin from = AimFrom(origin, false);
  if (wanted != kRoom && (flags[from.index] & kInWorkspace) != 0) {
    from = AimFrom(origin, true);
  }
  int redo[RaySet::kMaxRays + 1];
  const int before = taken_count;
  fan::Search search{PlaneOf(wanted).data(), marks.data(), taken.data(), taken_count, 0};
  const int unsure = fan::Gather(from, directions.front().data(), n, length, &search, redo);
  taken_count = search.found_count;
  for (int i = 0; i < unsure; ++i) {
    Search(origin, directions[redo[i]], length, wanted, [&](int cell) {
      ++search.wanted;
      Take(cell);
    });
  }
  return count == GainCount::kDistinct ? taken_count - before : search.wanted;
}

int GainEvaluator::Cells::DropBlocked(const Vector3d& origin, int n, double length) {
  int redo[RaySet::kMaxRays + 1];
  std::uint8_t blocked[RaySet::kMaxRays];
  const int unsure = fan::FindBlocked(AimFrom(origin, false), directions.front().data(), n, length,
                                      PlaneOf(kUnknown).data(), blocked, redo);
  for (int i = 0; i < unsure; ++i) {
    blocked[redo[i]] = Blocked(origin, directions[redo[i]], length) ? 1 : 0;
  }
  int left = 0;
  for (int i = 0; i < n; ++i) {
    directions[left] = directions[i];
    left += blocked[i] != 0 ? 0 : 1;
  }
  return left;
}

}  // namespace pipewright
