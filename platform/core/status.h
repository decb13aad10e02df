// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>
#include <cstdint>

namespace pipewright {

/// Why there is no value. Every enumerator has a test that provokes it.
// clang-format off  (version 14 misindents an attributed enum)
enum class [[nodiscard]] Status : std::uint8_t{
    kOk,
    kStale,           ///< input older than its timeout
    kOutOfRange,      ///< value outside its declared limits, or not finite
    kMalformed,       ///< wrong id, length, type or syntax
    kInfeasible,      ///< constraints admit no point
    kIterationLimit,  ///< work bound reached; the value is not to be used
    kFull,            ///< a fixed capacity is exhausted; what it holds is kept
    kUnavailable,     ///< a device, interface or file is not there
    kTimeout,         ///< the other side did not answer in time
    kFault,           ///< the other side answered with an error
};
// clang-format on

constexpr const char* Name(Status s) {
  switch (s) {
    case Status::kOk:
      return "ok";
    case Status::kStale:
      return "stale";
    case Status::kOutOfRange:
      return "out of range";
    case Status::kMalformed:
      return "malformed";
    case Status::kInfeasible:
      return "infeasible";
    case Status::kIterationLimit:
      return "iteration limit";
    case Status::kFull:
      return "full";
    case Status::kUnavailable:
      return "unavailable";
    case Status::kTimeout:
      return "timeout";
    case Status::kFault:
      return "fault";
  }
  return "?";
}

/// A T, or the reason there is none.
template <typename T>
class [[nodiscard]] Result {
 public:
  constexpr Result(const T& value) : value_(value) {}
  constexpr Result(Status why) : status_(why) { assert(why != Status::kOk); }

  constexpr bool ok() const { return status_ == Status::kOk; }
  constexpr Status status() const { return status_; }
  constexpr const T& operator*() const {
    assert(ok());
    return value_;
  }
  constexpr const T* operator->() const { return &**this; }

 private:
  T value_{};
  Status status_ = Status::kOk;
};

}  // namespace pipewright
