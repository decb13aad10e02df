// SPDX-License-Identifier: MIT
#include "plan/tour/held_karp.h"

#include <cassert>
#include <limits>

namespace pipewright {
namespace {

struct Last {
  float cost = std::numeric_limits<float>::infinity();
  int node = -1;
};

/// best(S, j) for all S that hold j, at S (n − 1) + j.
class Table {
 public:
  Table(const CostTable& costs, std::span<float> memory)
      : costs_(costs), others_(costs.size() - 1), memory_(memory) {}

  void Fill() {
    for (int set = 1; set < 1 << others_; ++set) {
      for (int j = 0; j < others_; ++j) {
        if ((set >> j & 1) != 0) {
          const int rest = set & ~(1 << j);
          At(set, j) = rest == 0 ? costs_(others_, j) : BestLast(rest, j).cost;
        }
      }
    }
  }

  /// The best way over all of `set`, which is not empty, and then to `to`.
  Last BestLast(int set, int to) const {
    Last best;
    for (int k = 0; k < others_; ++k) {
      if ((set >> k & 1) != 0) {
        const float cost = memory_[set * others_ + k] + costs_(k, to);
        best = best.node < 0 || cost < best.cost ? Last{cost, k} : best;
      }
    }
    return best;
  }

 private:
  float& At(int set, int j) { return memory_[set * others_ + j]; }

  const CostTable& costs_;
  int others_;  // nodes but the base, which is the last
  std::span<float> memory_;
};

}  // namespace

void HeldKarp::Solve(const CostTable& costs, std::span<float> memory, std::span<TourNode> order) {
  const int others = costs.size() - 1;
  assert(1 <= others && others < kNodesMax);
  assert(memory.size() >= static_cast<std::size_t>((1 << others) * others));
  Table table(costs, memory);
  table.Fill();
  order[0] = static_cast<TourNode>(others);
  int set = (1 << others) - 1;
  int to = others;
  for (int place = others; place > 0; --place) {
    to = table.BestLast(set, to).node;
    order[place] = static_cast<TourNode>(to);
    set &= ~(1 << to);
  }
}

}  // namespace pipewright
