// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <tuple>
#include <vector>

#include "hil/canlog/log_frame.h"

namespace pipewright::hil {

/// An id of a channel. 11-bit ids, 29-bit ones and error messages are apart.
struct IdKey {
  std::uint8_t channel = 0;
  bool error = false;
  bool extended = false;
  std::uint32_t id = 0;

  friend constexpr bool operator==(const IdKey&, const IdKey&) = default;
  friend constexpr bool operator<(const IdKey& a, const IdKey& b) {
    return std::tie(a.channel, a.error, a.extended, a.id) <
           std::tie(b.channel, b.error, b.extended, b.id);
  }
};

constexpr IdKey KeyOf(const LogFrame& frame) {
  return {frame.channel, frame.error, frame.extended, frame.id};
}

/// Something for each id that a log has, up to kMost of them: open addressing, found in a probe or
/// two.
template <typename T>
class IdTable {
 public:
  static constexpr std::size_t kMost = 65536;

  struct Entry {
    IdKey key;
    T value;
  };

  /// That of `key`, made if it is new; null: it is new and there is no room. Valid until another is
  /// made.
  T* Find(const IdKey& key) {
    const std::uint64_t bits = std::uint64_t{key.channel} << 32 | (key.error ? 1U << 30 : 0) |
                               (key.extended ? 1U << 31 : 0) | key.id;
    for (std::size_t slot = bits * kGolden >> kShift;; slot = (slot + 1) % kSlots) {
      if (slots_[slot] == 0) {
        if (entries_.size() == kMost) {
          return nullptr;
        }
        entries_.push_back({key, {}});
        slots_[slot] = static_cast<std::uint32_t>(entries_.size());
        return &entries_.back().value;
      }
      Entry& entry = entries_[slots_[slot] - 1];
      if (entry.key == key) {
        return &entry.value;
      }
    }
  }
  /// In the order in which they were made.
  std::vector<Entry>& entries() { return entries_; }
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  static constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15;
  static constexpr int kSlotBits = 18;
  static constexpr int kShift = 64 - kSlotBits;
  static constexpr std::size_t kSlots = std::size_t{1} << kSlotBits;
  static_assert(kSlots >= 2 * kMost, "a free slot is always near");

  std::vector<Entry> entries_;
  std::unique_ptr<std::uint32_t[]> slots_ =
      std::make_unique<std::uint32_t[]>(kSlots);  ///< entry + 1; 0: free
};

}  // namespace pipewright::hil
