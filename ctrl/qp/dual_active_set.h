// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cassert>

#include "ctrl/qp/qp.h"
#include "ctrl/qp/working_set.h"

namespace pipewright {

struct QpConfig {
  int max_iterations = 200;
  /// Of a row or bound at an optimum, in the row's unit; ten times that where the rows that meet in
  /// x determine it badly.
  double feasibility_tol = 1e-10;
  double stationarity_tol = 1e-9;  ///< of Hx + g + A'lambda, relative to its largest term
};

constexpr bool Valid(const QpConfig& c) {
  return c.max_iterations > 0 && c.feasibility_tol > 0 && c.stationarity_tol > 0;
}

/// Dual active-set method of Goldfarb and Idnani (Math. Programming 27, 1983) for QpProblem.
///
/// Why this one: it starts from the unconstrained minimum, so a start near the answer costs as many
/// iterations as rows differ; it ends with an infeasibility proof; and in control few rows are
/// active, so it touches few: J a_i is formed for active rows only, all others are tested as A x
/// in one sweep, which serves a few steps. Soft rows enter as d_i on the diagonal of the active
/// Gram matrix: no variable, and never dependent. See WorkingSet for the factor. Those that a warm
/// start takes for active go into H (FoldedRow): n^2 / 2 each in place of a member's n^2 / 2 + 2 n
/// k.
///
/// Work: per solve n^3 / 2 + rows n; per iteration (add or drop, k active) at most
/// 2 n k + 3/2 k^2 + n^2 + rows n multiply-adds. Every loop is bounded; the iteration cap bounds
/// the whole. No heap, no throw.
///
/// It ends: each row added raises the dual objective by viol^2 / (2 pivot) > 0, drops in between
/// only shrink the set, so no active set returns in exact arithmetic; in rounded arithmetic the cap
/// ends it.
///
/// Anytime-safe: let f satisfy all hard rows, and x be the capped iterate. On x(t) = f + t (x - f),
/// each hard side is a_i'f + t a_i'(x - f) <= hi_i, true at t = 0 and affine in t, so it holds up
/// to t_i = (hi_i - a_i'f) / a_i'(x - f) where the slope is positive, and for all t elsewhere. At
/// t = min(1, min t_i) >= 0 all hold. The answer is x(t), and is tested once more.
///
/// Optimal is a claim that is checked: after the last iteration the KKT residual in the original
/// data is computed, and refined with the factor at hand; if it stays above its tolerance the
/// status is kCapped.
template <int n, int m>
class QpSolver {
 public:
  explicit QpSolver(const QpConfig& config = {}) : config_(config) { assert(Valid(config)); }

  /// @param feasible  a point known to satisfy every hard row and the box (in control usually 0),
  ///                  or nullptr. When the solve is capped the answer lies between it and the
  ///                  last iterate, at the last point that satisfies every hard row.
  /// The result stays valid until the next call. Nothing of a failed solve is carried to the next.
  ///
  /// A start that does not end is followed by another, while iterations are left: with the active
  /// set folded when that is full, unfolded when folding wore the factor out, and from no active
  /// set when a remembered one is ill conditioned.
  const QpSolution<n, m>& Solve(const QpProblem<n, m>& qp, const Vec<n>* feasible = nullptr);

  /// Of the solves to come; at least 1.
  void LimitIterations(int max_iterations) {
    assert(max_iterations > 0);
    config_.max_iterations = max_iterations;
  }

  /// The next solve starts from no active set.
  void ForgetActiveSet() { warm_size_ = 0; }

 private:
  /// Hard rows that are active are independent, so at most n; of soft ones, 64 are held at a time:
  /// with one more, those in the set are folded and their places are free again.
  static constexpr int kMaxSoft = m < 64 ? m : 64;
  static constexpr int kMaxActive = n + kMaxSoft;
  static constexpr double kRounding = 1e-13;      ///< of A x, per |x|
  static constexpr double kSmallResidual = 1e-1;  ///< of the tolerances: nothing to refine
  static constexpr double kLargeResidual = 1e3;   ///< of the tolerances: folding has cost too much
  static constexpr double kWrongSign = 1e-10;     ///< a multiplier's, of the largest
  static constexpr double kSeedPivot = 1e-12;     ///< of |m|^2: less, and a remembered row waits
  static constexpr double kTiny = 1e-300;
  static constexpr double kNearlyAsMuch = 0.6;  ///< of the most violated: worth a step, too
  static constexpr double kLost = 1e6;  ///< of S's accuracy to rows taken out: more, and fold none
  static constexpr int kMaxCandidates = 8;                   ///< of one sweep
  static constexpr int kMaxRestarts = 2 + 2 * m / kMaxSoft;  ///< of a solve: see Solve
  static constexpr int kMaxRefinements = 4;
  static constexpr int kMaxRescues = 2;
  static constexpr double kWider = 10;      ///< times the tolerance, where rows are dependent
  static constexpr double kStiffest = 1e5;  ///< w |a|^2 of a folded row, of H's least diagonal
  using Set = qp::WorkingSet<n, kMaxActive>;
  using Member = typename Set::Member;
  using V = qp::PaddedVec<n>;
  using Problem = QpProblem<n, m>;

  enum class Step {
    kGoOn,
    kOptimal,
    kInfeasible,
    kCapped,
    kFull,
    kWornOut,
    kIllConditioned,
    kInvalid
  };

  struct Warm {
    int name;
    int key;
    int side;
  };

  // dual_active_set_start_inl.h
  Step Prepare(const Problem& qp);
  Step Contradiction(const Problem& qp);
  Step Seed(const Problem& qp);
  void SeedOne(const Problem& qp, int name, int side, bool equality);
  void Fold(const Problem& qp);
  int FindRow(const Problem& qp, const Warm& warm) const;
  V Row(const Problem& qp, int name) const;
  void MakeMember(const Problem& qp, int name, int side, const V& a, Member& c) const;
  void Mask(const Problem& qp, int name, bool active);
  bool Taken(int name) const;

  // dual_active_set_sweep_inl.h
  bool Sweep(const Problem& qp);
  double Violation(const Problem& qp, int name) const;
  int MostViolated(const Problem& qp) const;

  // dual_active_set_inl.h
  Step Start(const Problem& qp);
  Step Count();
  Step SolveFromSeed(const Problem& qp);
  Step Add(const Problem& qp, int name);
  int FirstFoldedToReachZero(const V& dx, double& t) const;
  Step TakeOut(const Problem& qp, int folded);
  Step Drop(const Problem& qp, int member);
  Step DropWrongSigns(const Problem& qp);
  void SolveOnWorkingSet();
  bool ProvesInfeasible(const Member& p) const;
  void NameConflict(const Member& p);

  // dual_active_set_polish_inl.h
  Step Polish(const Problem& qp);
  Step Refine(const Problem& qp);
  Step Refine(const Problem& qp, double residual, V& s);
  double Residual(const Problem& qp, V& s, double* w);
  void Correct(const V& s, double* w);

  // dual_active_set_report_inl.h
  void Report(const Problem& qp, Step end, const Vec<n>* feasible);
  void ReportMultipliers();
  void RememberActiveSet(const Problem& qp);
  void Retreat(const Problem& qp, const Vec<n>& from);
  bool HardFeasible(const Problem& qp, const Vec<n>& x) const;

  /// Follows |x| up once the rounding of A x does.
  double Tolerance() const {
    return widened_ *
           std::max(config_.feasibility_tol, kRounding * x_.template lpNorm<Eigen::Infinity>());
  }
  static double Lower(const Problem& qp, int name) {
    return name < m ? qp.lo[name] : qp.lb[name - m];
  }
  static double Upper(const Problem& qp, int name) {
    return name < m ? qp.hi[name] : qp.ub[name - m];
  }

  QpConfig config_;
  QpSolution<n, m> solution_;
  qp::InverseFactor<n> J_;  ///< of H with the folded rows
  qp::FoldedRow<n> folded_[m];
  int folded_count_ = 0;
  int begun_ = 0;       ///< the solve's iterations when this start began
  double widened_ = 1;  ///< factor of the tolerance
  bool fold_ = true;    ///< this start, what a warm one remembers
  double lost_ = 1;     ///< factor by which S has become less accurate
  Set set_;
  typename Set::Projection projection_;
  V x0_;  ///< the minimum without the set: -H^-1 g, both with the folded rows
  V x_;
  Vec<Problem::kStride> lo_;  ///< the problem's, with active and folded rows masked by infinities
  Vec<Problem::kStride> hi_;
  Vec<n> lb_;
  Vec<n> ub_;
  Vec<Problem::kStride> missed_;    ///< by how much x misses the rows, at the last sweep
  Vec<Problem::kStride / 8> most_;  ///< the largest of each eight of them
  int worst_ = -1;                  ///< of the last sweep: the row or bound that x missed by most
  int candidates_[n + Problem::kStride + 1];  ///< and those that it missed by nearly as much
  int candidate_count_ = 0;
  double worth_ = 0;  ///< what a candidate must be missed by
  double work_[Set::kStride];
  bool equalities_ = false;
  Warm warm_[m + n];
  int warm_size_ = 0;
};

/// The size the robot's controller uses, compiled once in dual_active_set.cc. For other sizes
/// include dual_active_set_inl.h.
inline constexpr int kControlQpVariables = 9;
inline constexpr int kControlQpRows = 192;
extern template class QpSolver<kControlQpVariables, kControlQpRows>;

}  // namespace pipewright
