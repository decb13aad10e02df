// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "perception/map/distance_cell.h"

namespace pipewright {

/// The nearest obstacle of every cell of a box, kept up with obstacles that come and go.
///
/// Three passes, each exact, after Saito and Toriwaki (1994): along x the nearest obstacle of each
/// row; along y the best of the rows of a layer; along z the best of the layers. What the first two
/// passes found is kept, so that a row that changes is offered only to the rows it can reach: a
/// cell takes it if it is nearer, and is sought anew if it stood on what is gone. Nothing else of
/// the box is touched, and since of two obstacles the smaller Packed wins, whatever the order, the
/// outcome is that of all passes over all cells, bit for bit.
///
/// All memory is taken at construction: five bytes a cell, and the caller's four.
class FeatureTransform {
 public:
  using Packed = distance_cell::Packed;

  FeatureTransform() = default;
  /// Of nx x ny x nz cells, x fastest, that are all obstacles. No obstacle is farther from its cell
  /// than `range` along any axis, at most 31.
  FeatureTransform(int nx, int ny, int nz, int range);

  bool SameShape(const FeatureTransform& other) const {
    return nx_ == other.nx_ && ny_ == other.ny_ && nz_ == other.nz_ && range_ == other.range_;
  }
  /// As of the last Update().
  bool ObstacleAt(int index) const { return offsets_[index] == 0; }

  /// Brings `cells` (what the last Update() left, or kHere everywhere before the first) to the
  /// obstacles of now. dirty[y + ny z] tells which rows along x may have changed, and is cleared;
  /// read(y, z, obstacle) writes a byte a cell of such a row, 0 or 1. With `anew`, all rows are
  /// read and nothing of before is used.
  template <typename ReadRow>
  void Update(bool anew, std::uint8_t* dirty, ReadRow read, Packed* cells);

  std::int64_t MemoryBytes() const;

 private:
  /// Cells lo to hi - 1 of a row.
  struct Span {
    int lo = 0;
    int hi = 0;

    bool empty() const { return lo == hi; }
    void Add(const Span& more) {
      lo = empty() ? more.lo : std::min(lo, more.lo);
      hi = std::max(hi, more.hi);
    }
  };

  void Unpack(int z, std::vector<Packed>* layer) const;
  void UpdateSheet(int z, bool anew, const std::uint8_t* dirty);
  void OfferSheet(int z, Packed* cells);
  void MendLost(Packed* cells);
  void MergeSheets(int from, int to, Packed* cells);
  static Span Difference(const Packed* a, const Packed* b, int n);

  int nx_ = 0;
  int ny_ = 0;
  int nz_ = 0;
  int range_ = 0;
  std::vector<std::int8_t> offsets_;  // first pass: along x to the nearest of the row
  std::vector<Packed> sheets_;        // second pass: the nearest of the layer
  // Scratch of one layer, before and now.
  std::vector<Packed> rows_before_;
  std::vector<Packed> rows_now_;
  std::vector<Packed> sheet_before_;
  std::vector<Span> lost_rows_;  // cells of a sheet's rows that stood on what is gone
  // Scratch of all.
  std::vector<Span> lost_;  // likewise of the rows of all layers
  std::vector<std::uint8_t> obstacle_;
  int offered_ = 0;  // rows of sheets that changed
};

template <typename ReadRow>
void FeatureTransform::Update(bool anew, std::uint8_t* dirty, ReadRow read, Packed* cells) {
  constexpr int kFew = 4;  // more than this share of all rows, and merging all is cheaper
  int first = nz_;         // layers that changed
  int last = -1;
  offered_ = 0;
  bool offer = !anew;
  for (int z = 0; z < nz_; ++z) {
    std::uint8_t* const rows = dirty + z * ny_;
    if (!anew && std::find(rows, rows + ny_, 1) == rows + ny_) {
      continue;
    }
    Unpack(z, &rows_before_);
    for (int y = 0; y < ny_; ++y) {
      if (anew || rows[y] != 0) {
        rows[y] = 1;
        read(y, z, obstacle_.data());
        distance_cell::SweepRow(obstacle_.data(), nx_, range_, &offsets_[nx_ * (y + ny_ * z)]);
      }
    }
    UpdateSheet(z, anew, rows);
    offer = offer && kFew * offered_ < ny_ * nz_;
    if (offer) {
      OfferSheet(z, cells);
    }
    std::fill(rows, rows + ny_, std::uint8_t{0});
    first = std::min(first, z);
    last = z;
  }
  if (offer) {
    MendLost(cells);
  } else {
    MergeSheets(std::max(first - range_, 0), std::min(last + range_, nz_ - 1), cells);
  }
}

}  // namespace pipewright
