// SPDX-License-Identifier: MIT
#include "perception/map/distance_cell.h"

#include <algorithm>

namespace pipewright::distance_cell {
namespace {

void TakeNearer(const Packed* from, Packed shift, int n, Packed* best) {
  for (int x = 0; x < n; ++x) {
    const Packed there = from[x] + shift;
    best[x] = there < best[x] ? there : best[x];
  }
}

}  // namespace

void SweepRow(const std::uint8_t* obstacle, int n, int range, std::int8_t* offsets) {
  int last = -2 * range;
  for (int x = 0; x < n; ++x) {
    last = obstacle[x] != 0 ? x : last;
    offsets[x] = x - last <= range ? static_cast<std::int8_t>(last - x) : kNoneInRow;
  }
  last = n + 2 * range;
  for (int x = n - 1; x >= 0; --x) {
    last = obstacle[x] != 0 ? x : last;
    const int left = offsets[x] == kNoneInRow ? kNoneInRow : -offsets[x];
    offsets[x] =
        last - x <= range && last - x < left ? static_cast<std::int8_t>(last - x) : offsets[x];
  }
}

// Stops as soon as no row that is still farther off can be nearer to any cell of this one: exact,
// and short amid obstacles.
void MergeRows(const Packed* from, const RowPlace& place, int n, int range, Packed* best) {
  std::copy(from, from + n, best);
  for (int off = 1; off <= range; ++off) {
    if (*std::max_element(best, best + n) <= (off * off << kDistanceShift)) {
      return;
    }
    if (place.at - off >= 0) {
      TakeNearer(from - off * place.stride, Shifted(-off, place.axis), n, best);
    }
    if (place.at + off < place.rows) {
      TakeNearer(from + off * place.stride, Shifted(off, place.axis), n, best);
    }
  }
}

bool Offer(const Packed* before, const Packed* now, Packed shift, int n, Packed* to) {
  Packed lost = 0;
  for (int x = 0; x < n; ++x) {
    const Packed was = before[x] + shift;
    const Packed is = now[x] + shift;
    lost |= (to[x] == was ? -1 : 0) & (was < is ? -1 : 0);
    to[x] = is < to[x] ? is : to[x];
  }
  return lost != 0;
}

}  // namespace pipewright::distance_cell
