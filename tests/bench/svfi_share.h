// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "tests/bench/svfi_loop.h"

namespace pipewright::bench {

/// How often something held, with Wilson's score bounds: each is passed by chance once in a
/// hundred times.
struct Share {
  long held = 0;
  long draws = 0;

  double value() const {
    return draws > 0 ? static_cast<double>(held) / static_cast<double>(draws) : 0;
  }
  double lower() const { return Bound(-1); }
  double upper() const { return Bound(1); }
  Share& operator+=(const Share& other) {
    held += other.held;
    draws += other.draws;
    return *this;
  }

 private:
  double Bound(int side) const;
};

/// Shares of draws of the true surface about the estimate, for the u that was sent.
struct TruthShares {
  Share first_order;  ///< of f linear in the parameters: what (12), (13) speak of
  Share full;         ///< of f itself, at surfaces drawn on the manifold
  Share with_buffer;  ///< as first_order, of f >= the buffer that the row keeps beyond the VFI
};

/// As (12) of the paper has it: truth ~ N(estimate, covariance), `draws` over all instances.
TruthShares DrawTruths(std::span<const Instance> instances, int draws, Rng& rng);

/// As a user lives it: the truth is fixed, the estimate drawn about it, and the controller, as it
/// stood, chooses u from that estimate. Whether the true VFI of the same robot point holds.
Share DrawEstimates(std::span<const Instance> instances, int draws, Rng& rng);

}  // namespace pipewright::bench
