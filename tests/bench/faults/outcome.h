// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace pipewright::bench {

/// What came of a fault.
enum class Outcome : std::uint8_t {
  kMasked,    ///< M: the limits held, and the robot went on
  kSafeStop,  ///< S: standstill within the bound, and no motion again without leave
  kLate,      ///< L: standstill, or the end of motion where it was due, after the bound or never
  kWrong,     ///< W: an unlawful command on the wire, a hard stop, or what had to be refused taken
  kCrash,     ///< C: the process died, or did not answer
};
inline constexpr int kOutcomes = 5;
inline constexpr std::string_view kOutcomeLetters = "MSLWC";

/// The counts of a row.
struct Tally {
  std::array<std::uint64_t, kOutcomes> counts{};
  std::vector<double> latencies_ms;  ///< from the fault until it was seen, of cases in which it was
  std::vector<std::string> notes;    ///< the first few W and L in words; what was measured besides

  void Add(Outcome outcome, std::uint64_t count = 1) {
    counts[static_cast<std::size_t>(outcome)] += count;
  }
  std::uint64_t of(Outcome outcome) const { return counts[static_cast<std::size_t>(outcome)]; }
  std::uint64_t n() const {
    std::uint64_t sum = 0;
    for (const std::uint64_t count : counts) {
      sum += count;
    }
    return sum;
  }
  void Note(const std::string& text) {
    constexpr std::size_t kMost = 12;
    if (notes.size() < kMost) {
      notes.push_back(text);
    }
  }
};

/// q in [0, 1]: the smallest value that so large a share does not exceed. 0 of nothing.
double Quantile(std::vector<double> values, double q);

}  // namespace pipewright::bench
