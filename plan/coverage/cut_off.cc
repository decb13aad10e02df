// SPDX-License-Identifier: MIT
#include "plan/coverage/cut_off.h"

namespace pipewright {
namespace {

/// The ways of one node that a tour can take.
struct Ways {
  int in = 0;
  int out = 0;
  bool through = false;
};

bool Takes(const TourProblem& p, double blocked, int from, int to) {
  return from != to && from != p.exit && to != p.entry &&
         !(p.n > 2 && from == p.entry && to == p.exit) && p.Cost(from, to) < blocked;
}

Ways WaysOf(const TourProblem& p, double blocked, int node) {
  Ways ways;
  int both = 0;  // nodes that are at the end of a way in and of one out
  for (int other = 0; other < p.n; ++other) {
    const bool in = Takes(p, blocked, other, node);
    const bool out = Takes(p, blocked, node, other);
    ways.in += in;
    ways.out += out;
    both += in && out;
  }
  const bool only_back = p.n > 2 && ways.in == 1 && ways.out == 1 && both == 1;
  ways.through = ways.in > 0 && ways.out > 0 && !only_back;
  return ways;
}

}  // namespace

void FindCutOff(const TourProblem& p, double blocked, std::vector<TourNode>& found) {
  const bool any_begins = p.open && p.entry == TourProblem::kFree;
  const bool any_ends = p.open && p.exit == TourProblem::kFree;
  int only_begin = 0;
  int only_end = 0;
  for (int node = 0; node < p.n; ++node) {
    const Ways ways = WaysOf(p, blocked, node);
    only_begin += ways.in == 0 && node != p.exit;
    only_end += ways.out == 0 && node != p.entry;
  }
  const auto fits = [&](int node, const Ways& ways) {
    if (node == p.entry || node == p.exit) {
      return node == p.entry ? ways.out > 0 : ways.in > 0;
    }
    const bool begins = any_begins && ways.out > 0 && (ways.in > 0 || only_begin == 1);
    const bool ends = any_ends && ways.in > 0 && (ways.out > 0 || only_end == 1);
    return ways.through || begins || ends;
  };
  found.clear();
  for (int node = 0; node < p.n; ++node) {
    if (!fits(node, WaysOf(p, blocked, node))) {
      found.push_back(static_cast<TourNode>(node));
    }
  }
}

}  // namespace pipewright
