// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "platform/core/time.h"

namespace pipewright {

/// When a search for a tour stops: whichever comes first.
struct TourBudget {
  std::int64_t trials = 1000;  ///< tours that are brought down to a local optimum; one is, always
  Time (*now)() = nullptr;     ///< the clock, as platform/linux's Now(); null: trials alone
  Time deadline = Time::max();
};

/// Watches a budget, and reads its clock at one in kReadEvery questions.
class TourClock {
 public:
  explicit TourClock(const TourBudget& budget) : budget_(budget) {}

  void CountTrial() { ++trials_; }
  std::int64_t trials() const { return trials_; }

  /// Whether the deadline is past; once it is, always. Late() may find out kReadEvery calls late.
  bool LateNow() {
    until_read_ = kReadEvery;
    late_ = late_ || (budget_.now != nullptr && budget_.now() >= budget_.deadline);
    return late_;
  }
  bool Late() { return late_ || (--until_read_ <= 0 && LateNow()); }
  bool Over() { return trials_ >= budget_.trials || Late(); }

 private:
  static constexpr int kReadEvery = 32;

  TourBudget budget_;
  std::int64_t trials_ = 0;
  int until_read_ = 0;
  bool late_ = false;
};

}  // namespace pipewright
