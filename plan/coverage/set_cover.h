// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plan/coverage/observations.h"
#include "platform/core/status.h"

namespace pipewright {

/// What is to be seen, and by whom it may be.
struct CoverProblem {
  /// r(p): by how many of the chosen each primitive is to be seen, by its id; as many as the
  /// Observations have. 0: need not be. What others see anyway is the caller's to subtract.
  std::span<const std::uint8_t> wanted = {};
  /// New ones, which a plan would have to go to; in any order.
  std::span<const ConfigurationId> candidates = {};
  /// Those that a plan has already and may keep or give up; in any order, none of them a candidate.
  std::span<const ConfigurationId> kept = {};
  /// What a primitive counts where a kept one sees it, if 100 where a candidate does; in
  /// [100, 10000]. At 100, a kept one goes first only where both gain the same. Where a plan of 172
  /// views had lost 26, 600 new ones made it 164 with 74 of the new; at 150, 171 with 34; beyond
  /// 200, little changes.
  int kept_percent = 100;
};

/// A primitive that is seen less often than wanted, whatever is chosen.
struct Shortfall {
  PrimitiveId primitive = 0;
  int missing = 0;  ///< of r(p)

  bool operator==(const Shortfall&) const = default;
};

/// Few configurations that together see every primitive as often as wanted: set multi-cover, each
/// configuration once at most, by greedy choice and pruning.
///
///   f(S) = Σ_p min(r(p), number of q ∈ S that see p)
///   next = argmax_q  w(q) · (f(S ∪ {q}) − f(S)),     w = 1, of a kept one kept_percent / 100
///
/// until f(S) = f(all). Ties go to a kept one, then to the lowest id, so that neither the order of
/// the candidates nor the history of the Observations matters. Gains only fall as S grows, so that
/// an old one is an upper bound: in a heap of bounds, only the top one is evaluated anew, and
/// chosen if it stays on top [Minoux 1978]. The choices are those of evaluating all.
///
/// Then whatever is not needed is dropped: a chosen q without which no primitive is seen less often
/// than wanted. Whoever sees the fewest wanted primitives, times w, goes first, since it takes away
/// the least of what makes others redundant: on random plans with twice the configurations needed,
/// 9 % more are dropped so than last chosen first, and 0.1 % fewer than by the best order found
/// that follows every drop. One pass will do: what was needed once stays so.
///
/// Weighed by 1 / w, no choice weighs less than 1 / H(d) of this, where d is the most wanted
/// primitives that one configuration sees, and H(d) = 1 + 1/2 + ... + 1/d ≤ 1 + ln d [Wolsey 1982].
///
/// Time: O(P + I + E · (L + log Q)) for P primitives, I incidences of the Q configurations offered,
/// at most L of one, and E evaluations, no more than 2 Q + I, nor than Q · (choices + 1); measured
/// on disks over a plane, 3 Q to 6 Q: 10 to 23 ms for 2,000,000 incidences of 5,000 configurations
/// on one core of an AMD EPYC. That is a third of what decrementing gains through ObserversOf()
/// takes, whose bound, O(I log Q), is better. All memory is taken at construction: 13 bytes a
/// configuration, 12 a primitive; 1.2 MiB for 5,000 and 100,000.
///
/// [Minoux 1978] Accelerated greedy algorithms for maximizing submodular set functions.
/// [Wolsey 1982] An analysis of the greedy algorithm for the submodular set covering problem.
class SetCover {
 public:
  static constexpr int kConfigurationsMax = 1 << 24;
  static constexpr int kPrimitivesMax = 1 << 25;

  /// For Observations of up to these capacities.
  SetCover(int configuration_capacity, int primitive_capacity);

  /// @returns kOk: chosen() sees all as often as wanted. kInfeasible: it sees as often as wanted
  ///   what can be, and the rest as often as can be; shortfalls() tells by how much that is less.
  ///   Otherwise nothing is chosen: kFull: the Observations are larger than this; kMalformed:
  ///   `wanted` is not one a primitive, or a configuration is offered twice; kOutOfRange: an
  ///   offered one is not there, or kept_percent
  Status Solve(const Observations& observations, const CoverProblem& problem);

  /// In the order of choice, without those dropped.
  std::span<const ConfigurationId> chosen() const { return chosen_; }
  /// Ascending.
  std::span<const Shortfall> shortfalls() const { return shortfalls_; }
  int dropped() const { return dropped_; }                   ///< chosen, and not needed in the end
  std::int64_t evaluations() const { return evaluations_; }  ///< gains that were counted

  std::size_t MemoryBytes() const;

 private:
  /// Order by weighed count, then kept, then lowest id, in one number.
  using Key = std::uint64_t;
  enum class Role : std::uint8_t { kNone, kCandidate, kKept, kDropped };

  Key KeyOf(ConfigurationId q, int count) const;
  static ConfigurationId IdOf(Key key);

  Status Admit(const Observations& observations, const CoverProblem& problem);
  Status Enlist(const Observations& observations, std::span<const ConfigurationId> ids, Role role);
  void Open(const Observations& observations, const CoverProblem& problem);
  int Gain(const Observations& observations, ConfigurationId q);
  void Choose(const Observations& observations);
  void Take(const Observations& observations, ConfigurationId q);
  void Prune(const Observations& observations, std::span<const std::uint8_t> wanted);
  bool IsNeeded(const Observations& observations, ConfigurationId q) const;

  int configuration_capacity_;
  int primitive_capacity_;
  int kept_percent_ = 100;
  int dropped_ = 0;
  std::int64_t left_ = 0;  // f(all) − f(S)
  std::int64_t evaluations_ = 0;
  std::vector<Role> roles_;         // by configuration
  std::vector<std::int32_t> open_;  // by primitive: how often it is still to be seen; < 0: surplus
  std::vector<Key> keys_;           // the heap of bounds; then the order of pruning
  std::vector<ConfigurationId> chosen_;
  std::vector<Shortfall> shortfalls_;
};

}  // namespace pipewright
