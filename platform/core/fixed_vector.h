// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>

namespace pipewright {

/// Up to kCapacity values, held in place. Being full is an answer, not an error.
template <typename T, int kCapacity>
class FixedVector {
 public:
  [[nodiscard]] constexpr bool push_back(const T& value) {
    if (size_ == kCapacity) {
      return false;
    }
    items_[size_++] = value;
    return true;
  }
  constexpr void pop_back() {
    assert(size_ > 0);
    --size_;
  }
  constexpr void clear() { size_ = 0; }

  static constexpr int capacity() { return kCapacity; }
  constexpr int size() const { return size_; }
  constexpr bool empty() const { return size_ == 0; }
  constexpr bool full() const { return size_ == kCapacity; }
  constexpr const T& operator[](int i) const {
    assert(0 <= i && i < size_);
    return items_[i];
  }
  constexpr T& operator[](int i) {
    assert(0 <= i && i < size_);
    return items_[i];
  }
  constexpr const T& back() const { return (*this)[size_ - 1]; }
  constexpr T& back() { return (*this)[size_ - 1]; }
  constexpr const T* begin() const { return items_; }
  constexpr const T* end() const { return items_ + size_; }
  constexpr T* begin() { return items_; }
  constexpr T* end() { return items_ + size_; }

 private:
  T items_[kCapacity]{};
  int size_ = 0;
};

}  // namespace pipewright
