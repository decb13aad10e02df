// SPDX-License-Identifier: MIT
#include "plan/tour/edge_assembly.h"

#include <utility>

namespace pipewright {

EdgeAssembly::EdgeAssembly(int node_capacity)
    : a_(node_capacity),
      b_(node_capacity),
      a_cost_out_(node_capacity),
      on_cycle_(node_capacity),
      begin_(node_capacity / 2 + 1),
      seen_(node_capacity),
      child_(node_capacity) {}

void EdgeAssembly::Links::Assign(std::span<const TourNode> order) {
  TourNode before = order.back();
  for (const TourNode x : order) {
    next[before] = x;
    previous[x] = before;
    before = x;
  }
}

int EdgeAssembly::Begin(std::span<const TourNode> a, std::span<const TourNode> b,
                        const CostTable& costs) {
  a_.Assign(a);
  b_.Assign(b);
  const auto n = static_cast<int>(a.size());
  if (costs.symmetric()) {  // B may as well be the other way round: as is more like A
    int more_alike = 0;
    for (int x = 0; x < n; ++x) {
      more_alike += (a_.next[x] == b_.next[x] ? 1 : 0) - (a_.next[x] == b_.previous[x] ? 1 : 0);
    }
    if (more_alike < 0) {
      std::swap(b_.next, b_.previous);
    }
  }
  for (int x = 0; x < n; ++x) {
    a_cost_out_[x] = costs(x, a_.next[x]);
    seen_[x] = a_.next[x] == b_.next[x] ? 1 : 0;
  }
  int cycles = 0;
  TourNode end = 0;
  begin_[0] = 0;
  for (int x = 0; x < n; ++x) {
    if (seen_[x] != 0) {
      continue;
    }
    for (TourNode t = static_cast<TourNode>(x); seen_[t] == 0; t = b_.previous[a_.next[t]]) {
      seen_[t] = 1;
      on_cycle_[end++] = t;
    }
    begin_[++cycles] = end;
  }
  return cycles;
}

bool EdgeAssembly::MakeChild(int k, const CostTable& costs, const Neighbours& neighbours) {
  const auto n = static_cast<std::size_t>(costs.size());
  child_.Assign({a_.next.data(), n}, {a_.previous.data(), n}, {a_cost_out_.data(), n});
  for (TourNode i = begin_[k]; i < begin_[k + 1]; ++i) {
    const TourNode t = on_cycle_[i];
    child_.SetNext(t, b_.next[t], costs(t, b_.next[t]));
  }
  return child_.Join(costs, neighbours);
}

bool EdgeAssembly::JoinParts(std::span<const TourNode> next, const CostTable& costs,
                             const Neighbours& neighbours) {
  child_.Assign(next, costs);
  return child_.Join(costs, neighbours);
}

std::size_t EdgeAssembly::MemoryBytes() const {
  return (4 * a_.next.capacity() + on_cycle_.capacity() + begin_.capacity()) * sizeof(TourNode) +
         a_cost_out_.capacity() * sizeof(float) + seen_.capacity() + child_.MemoryBytes();
}

}  // namespace pipewright
