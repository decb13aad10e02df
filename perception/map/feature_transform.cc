// SPDX-License-Identifier: MIT
#include "perception/map/feature_transform.h"

#include <utility>

namespace pipewright {

using namespace distance_cell;  // NOLINT(google-build-using-namespace): this file's own words

FeatureTransform::FeatureTransform(int nx, int ny, int nz, int range)
    : nx_(nx), ny_(ny), nz_(nz), range_(range) {
  const std::size_t layer = static_cast<std::size_t>(nx) * ny;
  const std::size_t rows = static_cast<std::size_t>(ny) * nz;
  offsets_.assign(layer * nz, 0);
  sheets_.assign(layer * nz, kHere);
  rows_before_.resize(layer);
  rows_now_.resize(layer);
  sheet_before_.resize(layer);
  lost_rows_.resize(static_cast<std::size_t>(ny));
  lost_.resize(rows);
  obstacle_.resize(static_cast<std::size_t>(nx));
}

void FeatureTransform::Unpack(int z, std::vector<Packed>* layer) const {
  const int cells = nx_ * ny_;
  const std::int8_t* const offsets = &offsets_[cells * z];
  Packed* const to = layer->data();
  for (int i = 0; i < cells; ++i) {
    to[i] = offsets[i] == kNoneInRow ? kNone : kHere + Shifted(offsets[i], 0);
  }
}

FeatureTransform::Span FeatureTransform::Difference(const Packed* a, const Packed* b, int n) {
  Span span;
  while (span.lo < n && a[span.lo] == b[span.lo]) {
    ++span.lo;
  }
  span.hi = n;
  while (span.hi > span.lo && a[span.hi - 1] == b[span.hi - 1]) {
    --span.hi;
  }
  return span.empty() ? Span{} : span;
}

// The second pass of a layer whose rows are swept.
void FeatureTransform::UpdateSheet(int z, bool anew, const std::uint8_t* dirty) {
  constexpr int kFew = 5;  // as in Update()
  Packed* const sheet = &sheets_[nx_ * ny_ * z];
  std::copy(sheet, sheet + nx_ * ny_, sheet_before_.begin());
  Unpack(z, &rows_now_);
  const bool merge = anew || kFew * std::count(dirty, dirty + ny_, 1) > ny_;
  if (merge) {
    for (int y = 0; y < ny_; ++y) {
      MergeRows(&rows_now_[nx_ * y], {y, ny_, nx_, 1}, nx_, range_, sheet + nx_ * y);
    }
    return;
  }
  for (int y = 0; y < ny_; ++y) {
    const int row = nx_ * y;
    const Span span = dirty[y] != 0 ? Difference(&rows_before_[row], &rows_now_[row], nx_) : Span{};
    for (int to = std::max(y - range_, 0); !span.empty() && to <= std::min(y + range_, ny_ - 1);
         ++to) {
      if (Offer(&rows_before_[row + span.lo], &rows_now_[row + span.lo], Shifted(y - to, 1),
                span.hi - span.lo, sheet + nx_ * to + span.lo)) {
        lost_rows_[to].Add(span);
      }
    }
  }
  for (int y = 0; y < ny_; ++y) {
    const Span lost = std::exchange(lost_rows_[y], {});
    if (!lost.empty()) {
      const int at = nx_ * y + lost.lo;
      MergeRows(&rows_now_[at], {y, ny_, nx_, 1}, lost.hi - lost.lo, range_, sheet + at);
    }
  }
}

// A layer whose sheet changed, to the cells of all layers it can reach.
void FeatureTransform::OfferSheet(int z, Packed* cells) {
  const int layer = nx_ * ny_;
  const Packed* const sheet = &sheets_[layer * z];
  for (int y = 0; y < ny_; ++y) {
    const Span span = Difference(&sheet_before_[nx_ * y], sheet + nx_ * y, nx_);
    if (span.empty()) {
      continue;
    }
    ++offered_;
    const int at = nx_ * y + span.lo;
    for (int to = std::max(z - range_, 0); to <= std::min(z + range_, nz_ - 1); ++to) {
      if (Offer(&sheet_before_[at], sheet + at, Shifted(z - to, 2), span.hi - span.lo,
                cells + layer * to + at)) {
        lost_[y + ny_ * to].Add(span);
      }
    }
  }
}

void FeatureTransform::MendLost(Packed* cells) {
  for (int row = 0; row < ny_ * nz_; ++row) {
    const Span lost = std::exchange(lost_[row], {});
    if (!lost.empty()) {
      const int at = nx_ * row + lost.lo;
      MergeRows(&sheets_[at], {row / ny_, nz_, nx_ * ny_, 2}, lost.hi - lost.lo, range_,
                cells + at);
    }
  }
}

void FeatureTransform::MergeSheets(int from, int to, Packed* cells) {
  for (int row = ny_ * from; row < ny_ * (to + 1); ++row) {
    MergeRows(&sheets_[nx_ * row], {row / ny_, nz_, nx_ * ny_, 2}, nx_, range_, cells + nx_ * row);
  }
  std::fill(lost_.begin(), lost_.end(), Span{});
}

std::int64_t FeatureTransform::MemoryBytes() const {
  const auto bytes = [](const auto& v) {
    return static_cast<std::int64_t>(v.capacity() * sizeof(v[0]));
  };
  return bytes(offsets_) + bytes(sheets_) + bytes(rows_before_) + bytes(rows_now_) +
         bytes(sheet_before_) + bytes(lost_rows_) + bytes(lost_) + bytes(obstacle_);
}

}  // namespace pipewright
