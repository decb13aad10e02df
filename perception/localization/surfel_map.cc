// SPDX-License-Identifier: MIT
#include "perception/localization/surfel_map.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace pipewright {
namespace {

constexpr double kFar_cells = 1e5;
constexpr double kBetter = 4;       ///< times the variance, of what is replaced
constexpr double kNoiseSigmas = 3;  ///< λ_0 may be this much above what the noise explains

bool IsPowerOfTwo(int n) { return (n & (n - 1)) == 0; }

bool FarBetter(const Placement& a, const Placement& b) { return kBetter * a.at_1m() < b.at_1m(); }

}  // namespace

SurfelMap::SurfelMap(const SurfelMapConfig& config) : config_(config) { assert(Valid(config)); }

void SurfelMap::Clear() {
  slots_.fill({});
  cells_ = 0;
  refused_ = 0;
}

bool SurfelMap::KeyOf(const Vector3d& p_WQ, Key& key) const {
  for (int i = 0; i < 3; ++i) {
    const double cells = std::floor(p_WQ(i) / config_.cell_m);
    if (!(std::abs(cells) < kFar_cells)) {
      return false;
    }
    key[i] = static_cast<int>(cells);
  }
  return true;
}

/// The slot that holds the key, else the free one where it belongs. The table is never full.
int SurfelMap::Slot(const Key& key) const {
  const auto part = [&key](int i) { return static_cast<std::uint32_t>(key[i]); };
  std::uint32_t hash = part(0) * 73856093U ^ part(1) * 19349663U ^ part(2) * 83492791U;
  hash ^= hash >> 15;
  int slot = static_cast<int>(hash % kSlots);
  while (slots_[slot].used && slots_[slot].key != key) {
    slot = (slot + 1) % kSlots;
  }
  return slot;
}

const SurfelMap::Cell* SurfelMap::At(const Key& key) const {
  const Cell& cell = slots_[Slot(key)];
  return cell.used ? &cell : nullptr;
}

Status SurfelMap::Add(const Vector3d& p_WQ, double sigma_m, const Vector3d& p_WS,
                      const Placement& placed) {
  Key key;
  if (!KeyOf(p_WQ, key) || !(sigma_m > 0) || !std::isfinite(sigma_m)) {
    return Status::kOutOfRange;
  }
  Cell& cell = slots_[Slot(key)];
  if (!cell.used) {
    if (cells_ == kMaxCells) {
      ++refused_;
      return Status::kFull;
    }
    ++cells_;
    cell.used = true;
    cell.key = key;
  }
  Moments& sum = cell.moments;
  if (sum.count > 0 && FarBetter(placed, sum.placed())) {
    sum = {};
  }
  if (sum.count >= config_.count_max) {
    return Status::kOk;
  }
  Vector3d x;
  for (int i = 0; i < 3; ++i) {
    x(i) = p_WQ(i) / config_.cell_m - key[i] - 0.5;
  }
  const double w = 1 / (sigma_m * sigma_m);
  sum.w += w;
  sum.wx += w * x;
  int k = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      sum.wxx[k++] += w * x(i) * x(j);
    }
  }
  sum.w_placed_m2 += w * placed.m2;
  sum.w_placed_rad2 += w * placed.rad2;
  ++sum.count;
  if (sum.count >= config_.count_min &&
      (IsPowerOfTwo(sum.count) || sum.count == config_.count_max)) {
    Fit(cell, p_WS);
  }
  return Status::kOk;
}

/// Of a cell and its neighbours, about the cell's centre.
SurfelMap::Moments SurfelMap::Block(const Cell& center) const {
  const Key& key = center.key;
  const Placement placed = center.moments.placed();
  Moments sum;
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dz = -1; dz <= 1; ++dz) {
        const Cell* cell = At({key[0] + dx, key[1] + dy, key[2] + dz});
        if (cell == nullptr || cell->moments.count == 0 ||
            FarBetter(placed, cell->moments.placed())) {
          continue;
        }
        // Σ w (x + s)(x + s)' = Σ w x x' + s Σ w x' + Σ w x s' + W s s'
        const Moments& m = cell->moments;
        const Vector3d s(dx, dy, dz);
        int k = 0;
        for (int i = 0; i < 3; ++i) {
          for (int j = i; j < 3; ++j) {
            sum.wxx[k] += m.wxx[k] + s(i) * m.wx(j) + m.wx(i) * s(j) + m.w * s(i) * s(j);
            ++k;
          }
        }
        sum.wx += m.wx + m.w * s;
        sum.w += m.w;
        sum.w_placed_m2 += m.w_placed_m2;
        sum.w_placed_rad2 += m.w_placed_rad2;
        sum.count += m.count;
      }
    }
  }
  return sum;
}

void SurfelMap::Fit(Cell& cell, const Vector3d& p_WS) const {
  const Moments sum = Block(cell);
  const Vector3d mean = sum.wx / sum.w;
  Matrix3d S;
  int k = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      S(i, j) = S(j, i) = sum.wxx[k++] / sum.w - mean(i) * mean(j);
    }
  }
  Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
  solver.computeDirect(S);
  const Vector3d lambda = solver.eigenvalues();  // in cells²
  const double unit2 = config_.cell_m * config_.cell_m;
  const double noise = sum.count / sum.w / unit2;  // the harmonic mean of σ²
  const double across = std::max(lambda(0), noise);
  const double tilt = across / (sum.count * lambda(1));
  const double chance = 1 + kNoiseSigmas * std::sqrt(2.0 / sum.count);
  cell.has_surfel = lambda(1) > config_.spread * config_.spread &&
                    lambda(0) < chance * noise + config_.bend * config_.bend &&
                    tilt < config_.tilt_rad * config_.tilt_rad;
  if (!cell.has_surfel) {
    return;
  }
  const Vector3d center(cell.key[0] + 0.5, cell.key[1] + 0.5, cell.key[2] + 0.5);
  Surfel& surfel = cell.surfel;
  surfel.p_W = config_.cell_m * (center + mean);
  surfel.n_W = solver.eigenvectors().col(0);
  if (surfel.n_W.dot(p_WS - surfel.p_W) < 0) {
    surfel.n_W = -surfel.n_W;
  }
  surfel.offset_var_m2 = across / sum.count * unit2;
  surfel.rough_var_m2 = std::max(0.0, lambda(0) - noise) * unit2;
  surfel.tilt_var_rad2 = tilt;
  surfel.placed = sum.placed();
}

/// The six cells with a face in common with a cell, as far as they hold points.
template <typename Visit>
void SurfelMap::ForEachBeside(const Key& key, const Visit& visit) const {
  for (int axis = 0; axis < 3; ++axis) {
    for (const int step : {-1, 1}) {
      Key beside = key;
      beside[axis] += step;
      if (const Cell* cell = At(beside); cell != nullptr) {
        visit(*cell);
      }
    }
  }
}

const SurfelMap::Cell* SurfelMap::FindCell(const Vector3d& p_WQ) const {
  Key key;
  if (!KeyOf(p_WQ, key)) {
    return nullptr;
  }
  const Cell* own = At(key);
  if (own != nullptr && own->has_surfel) {
    return own;
  }
  const Cell* nearest = nullptr;
  double least_m2 = std::numeric_limits<double>::infinity();
  ForEachBeside(key, [&](const Cell& cell) {
    const double d2 = (cell.surfel.p_W - p_WQ).squaredNorm();
    if (cell.has_surfel && d2 < least_m2) {
      least_m2 = d2;
      nearest = &cell;
    }
  });
  return nearest;
}

const Surfel* SurfelMap::Find(const Vector3d& p_WQ) const {
  const Cell* cell = FindCell(p_WQ);
  return cell != nullptr ? &cell->surfel : nullptr;
}

void SurfelMap::Forget(const Vector3d& p_WQ) {
  if (const Cell* cell = FindCell(p_WQ); cell != nullptr) {
    Cell& held = slots_[Slot(cell->key)];
    held.moments = {};
    held.has_surfel = false;
  }
}

int SurfelMap::Loose(const Vector3d& p_WQ) const {
  Key key;
  if (!KeyOf(p_WQ, key)) {
    return 0;
  }
  const Cell* own = At(key);
  if (own != nullptr && own->has_surfel) {
    return 0;
  }
  int count = own != nullptr ? own->moments.count : 0;
  ForEachBeside(key, [&](const Cell& cell) { count += cell.has_surfel ? 0 : cell.moments.count; });
  return count;
}

}  // namespace pipewright
