// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cstring>

#include "perception/map/voxel_grid.h"

namespace pipewright {
namespace {

constexpr int kRow = 8;

/// Bit i of a byte to bits 2i and 2i + 1: a row's mask as the codes lie.
constexpr std::array<std::uint16_t, 256> Doubled() {
  std::array<std::uint16_t, 256> doubled{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    for (unsigned i = 0; i < 8; ++i) {
      doubled[byte] = static_cast<std::uint16_t>(doubled[byte] | ((byte >> i) & 1U) * 3U << 2 * i);
    }
  }
  return doubled;
}

constexpr std::array<std::uint16_t, 256> kDoubled = Doubled();
constexpr unsigned kKnownBits = 0xAAAA;
constexpr unsigned kOccupiedBits = 0x5555;

}  // namespace

// A scan's hits and misses of eight voxels from v on, v.x a multiple of 8: a row of a brick. Bits
// outside the box are 0.
void VoxelGrid::UpdateRow(const VoxelIndex& v, std::uint32_t hits, std::uint32_t misses,
                          ScanStats* stats) {
  StoredLogOdds* const row = LogOddsSlot(v);
  if (row == nullptr) {
    const int refused = __builtin_popcount(hits | misses);
    updates_refused_ += refused;
    stats->refused += refused;
    return;
  }
  stats->hits += __builtin_popcount(hits);
  stats->misses += __builtin_popcount(misses);
  std::uint32_t occupied = 0;
  for (std::uint32_t i = 0; i < kRow; ++i) {
    const std::uint32_t bit = 1U << i;
    const StoredLogOdds change = (hits & bit) != 0 ? hit_ : (misses & bit) != 0 ? miss_ : 0;
    const auto sum = static_cast<StoredLogOdds>(row[i] + change);
    const StoredLogOdds log_odds = std::min(std::max(sum, min_), max_);
    row[i] = log_odds;
    occupied |= log_odds >= threshold_ ? bit : 0;
  }
  // The row in the flat planes: all of it, or as much as is in the box.
  const std::int64_t first = FlatIndex(v);
  if (v.x < config_.lo.x || v.x + kRow - 1 > config_.hi.x) {
    for (std::uint32_t left = hits | misses; left != 0; left &= left - 1) {
      const int i = __builtin_ctz(left);
      Become(static_cast<int>(first) + i, {v.x + i, v.y, v.z}, ((occupied >> i) & 1U) != 0);
    }
  } else {
    std::uint32_t word = 0;
    const std::uint8_t* const at = reinterpret_cast<std::uint8_t*>(codes_.data()) + first / 4;
    std::memcpy(&word, at, sizeof word);
    const std::uint32_t codes = (word >> 2 * (first & 3)) & 0xFFFFU;
    const std::uint32_t touched = kDoubled[hits | misses];
    const std::uint32_t wanted = (codes & ~touched) | (touched & kKnownBits) |
                                 (touched & kDoubled[occupied] & kOccupiedBits);
    const std::uint32_t differ = codes ^ wanted;
    for (std::uint32_t left = (differ | differ >> 1) & kOccupiedBits; left != 0; left &= left - 1) {
      const int i = __builtin_ctz(left) / 2;
      Become(static_cast<int>(first) + i, {v.x + i, v.y, v.z}, ((occupied >> i) & 1U) != 0);
    }
  }
  for (std::uint32_t left = hits; left != 0; left &= left - 1) {
    const int i = __builtin_ctz(left);
    MarkSolid(static_cast<int>(first) + i, row[i]);
  }
}

}  // namespace pipewright
