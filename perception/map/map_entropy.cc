// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "perception/map/voxel_grid.h"

namespace pipewright {
namespace {

constexpr double kEntropyUnit = 1.0 / (std::int64_t{1} << 40);  // nats; sums of these are exact
constexpr int kEntropyIntervals = 4096;
constexpr double kLn2 = 0.69314718055994530942;

double EntropyOf(double log_odds) {
  const double p = 1 - 1 / (1 + std::exp(log_odds));
  return -p * std::log(p) - (1 - p) * std::log(1 - p);
}

}  // namespace

void VoxelGrid::TabulateEntropy() {
  entropy_table_.resize(kEntropyIntervals + 2);
  for (int i = 0; i < kEntropyIntervals + 2; ++i) {
    const double log_odds = min_ + (static_cast<double>(max_) - min_) * i / kEntropyIntervals;
    entropy_table_[i] = std::llround(EntropyOf(log_odds * kLogOddsUnit) / kEntropyUnit);
  }
}

std::int64_t VoxelGrid::EntropyUnits(StoredLogOdds log_odds) const {
  const double u = (static_cast<double>(log_odds) - min_) / (static_cast<double>(max_) - min_) *
                   kEntropyIntervals;
  const int i = static_cast<int>(u);
  const auto step = static_cast<double>(entropy_table_[i + 1] - entropy_table_[i]);
  return entropy_table_[i] + static_cast<std::int64_t>(step * (u - i));
}

double VoxelGrid::visual_entropy() const {
  const VoxelIndex& lo = config_.workspace_lo;
  const VoxelIndex& hi = config_.workspace_hi;
  std::int64_t units = 0;  // of the known voxels of W, in 2^-40 nats
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x;) {
        const int end = std::min(hi.x, x | 7) + 1;
        const int brick = top_[BrickOf({x, y, z})];
        for (int index = IndexOf({x, y, z}); brick >= 0 && x < end; ++x, ++index) {
          units +=
              KnownAt(index) ? EntropyUnits(bricks_[brick].log_odds[CellInBrick({x, y, z})]) : 0;
        }
        x = end;
      }
    }
  }
  const int not_known = counts_.unknown + counts_.residual;
  return (not_known * kLn2 + static_cast<double>(units) * kEntropyUnit) / counts_.total;
}

double VoxelGrid::coverage_entropy() const {
  return (counts_.occupied - counts_.covered) * kLn2 / counts_.total;
}

}  // namespace pipewright
