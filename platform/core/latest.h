// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>

namespace pipewright {

/// The newest T, from one writer thread to one reader thread, without lock or copy.
///
/// Three slots rotate: the writer fills one, the reader holds one, the third lies between. Each
/// side swaps its slot for the middle one in a single atomic exchange, so both are wait-free.
/// What is published twice before it is read is lost on purpose: only the newest counts.
template <typename T>
class Latest {
 public:
  Latest() = default;

  /// For a T without a default, or whose memory is sized at start: all slots begin as copies.
  explicit Latest(const T& initial) : slots_{initial, initial, initial} {}

  /// The writer's slot, holding an old value. Fill it in place, then Publish().
  T& Back() { return slots_[back_]; }

  /// Hands the writer's slot over.
  void Publish() {
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) &
            kSlotMask;
  }

  void Write(const T& value) {
    Back() = value;
    Publish();
  }

  /// The newest value published, or the initial one before the first. The reference stays valid,
  /// and its value unchanged, until the reader's next call.
  const T& Read() {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) != 0) {
      front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kSlotMask;
    }
    return slots_[front_];
  }

  /// Reader's side: whether Read() would return something new.
  bool HasNew() const { return (middle_.load(std::memory_order_acquire) & kFresh) != 0; }

 private:
  static constexpr std::uint8_t kSlotMask = 3;
  static constexpr std::uint8_t kFresh = 4;

  T slots_[3]{};
  std::uint8_t back_ = 0;
  std::atomic<std::uint8_t> middle_ = 1;
  std::uint8_t front_ = 2;
};

}  // namespace pipewright
