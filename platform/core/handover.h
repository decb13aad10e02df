// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>

namespace pipewright {

/// Every T, in order, from one writer thread to one reader thread, without lock, wait or heap.
/// (Latest<T> hands over the newest alone.) What comes while it is full is dropped and counted.
///
///   Handover<ControlReport, 256> reports;
///   reports.Push(report);                                          // writer
///   while (const ControlReport* r = reports.Front()) { ...; reports.Pop(); }   // reader
template <typename T, int kCapacity>
class Handover {
 public:
  /// Writer's side. False: full.
  bool Push(const T& value) {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) == kCapacity) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    items_[tail % kCapacity] = value;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Reader's side: the oldest value not yet popped, or nullptr. Valid until Pop().
  const T* Front() const {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    return head == tail_.load(std::memory_order_acquire) ? nullptr : &items_[head % kCapacity];
  }
  /// Only after Front() has given a value.
  void Pop() { head_.store(head_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

  /// Any thread.
  std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  T items_[kCapacity]{};
  std::atomic<std::uint64_t> tail_ = 0;  ///< pushed so far
  std::atomic<std::uint64_t> head_ = 0;  ///< popped so far
  std::atomic<std::uint64_t> dropped_ = 0;
};

}  // namespace pipewright
