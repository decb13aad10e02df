// SPDX-License-Identifier: MIT
#include "plan/cfnbv/cfnbv.h"

#include <algorithm>
#include <cassert>
#include <optional>
#include <utility>

#include "perception/map/voxel_grid.h"
#include "plan/cfnbv/cfnbv_memory.h"
#include "plan/cfnbv/proposals.h"

namespace pipewright {
namespace {

/// Rounds in one step whose every worthwhile view lacked a path, until the step gives in.
constexpr int kPathlessRounds = 3;

}  // namespace

Cfnbv::Cfnbv(const CfnbvConfig& config, const MapConfig& map)
    : config_(config), memory_(std::make_unique<Memory>(config, map)) {
  assert(Valid(config));
}

Cfnbv::~Cfnbv() = default;

std::span<const VoxelIndex> Cfnbv::NewResidual() const { return memory_->residual; }

void Cfnbv::ForgetFailures() {
  memory_->failures.ForgetAll();
  memory_->room_goals = 0;
}

/// Learns from how the last goal ended. `gains` must be fresh.
void Cfnbv::NoteOutcome(const PlanInput& input) {
  Memory& m = *memory_;
  switch (input.outcome) {
    case GoalState::kReached:
      TallyWay(input.q);
      break;
    case GoalState::kStalled:
      m.failures.AddStall(m.last_view);
      break;
    case GoalState::kNone:
    case GoalState::kMoving:
      break;
  }
  const MapCounts& counts = input.map.counts();
  if (counts.free + counts.occupied >= m.known_at_pathless + config_.forget_voxels) {
    m.failures.ForgetPathless();
    m.room_goals = 0;
    m.known_at_pathless = counts.free + counts.occupied;
  }
}

void Cfnbv::Passed(const Configuration& q) {
  constexpr double kApart_m = 0.02;
  Memory& m = *memory_;
  const Vector3d p_WP = ViewpointOf(q).p_WP;
  const int last = (m.passed_count + kMaxPassed - 1) % kMaxPassed;
  if (m.passed_count == 0 || (m.passed[last] - p_WP).norm() >= kApart_m) {
    m.passed[m.passed_count % kMaxPassed] = p_WP;
    m.passed_count = m.passed_count + 1 < 2 * kMaxPassed ? m.passed_count + 1 : kMaxPassed;
  }
}

/// Marks the surface that the probe met since the last plan. `gains` must be fresh.
void Cfnbv::NotePassed(const PlanInput& input, PlanStep& step) {
  Memory& m = *memory_;
  Passed(input.q);
  if (m.surface.Update(input.map, input.scene, config_.surface_frames) != Status::kOk) {
    step.status = Status::kFull;
  }
  for (const SurfacePatch& patch : m.surface.patches()) {
    for (int i = 0; i < std::min(m.passed_count, kMaxPassed); ++i) {
      if (m.gains.SurfaceMet(m.passed[i], patch)) {
        m.surface.MarkMet(patch);
        break;
      }
    }
  }
  m.passed_count = 0;
  static_cast<void>(m.surface.Update(input.map, input.scene, config_.surface_frames));
  m.gains.SetSurface(m.surface.patches());  // the list has been rebuilt, maybe shorter
}

void Cfnbv::Refresh(const VoxelGrid& map) {
  Memory& m = *memory_;
  m.failures.Refresh();
  m.gains.Update(map, m.failures.Ignored());
  m.gains.SetSurface(m.surface.patches());
}

/// Fills the store of candidates with one round's draws.
void Cfnbv::Propose(const PlanInput& input, Rng& rng, bool with_kept, PlanStep& step) {
  Memory& m = *memory_;
  const CollisionChecker checker({input.field, input.map, input.scene}, config_.motion.collision);
  m.candidates.clear();
  const auto take = [&](const std::optional<Configuration>& q, CandidateKind kind) {
    ++step.numbers.candidates;
    Candidate candidate;
    candidate.kind = kind;
    candidate.q = q.value_or(candidate.q);
    if (q && !m.candidates.push_back(candidate)) {
      step.status = Status::kFull;
    }
  };
  for (int i = 0; with_kept && i < m.kept.size(); ++i) {
    take(checker.Free(m.kept[i]) ? std::optional(m.kept[i]) : std::nullopt, CandidateKind::kKept);
  }
  Proposer proposer(checker, m.gains, m.surface.patches(), input.q, rng);
  const std::pair<CandidateKind, int> draws[] = {
      {CandidateKind::kUncovered, config_.uncovered_candidates},
      {CandidateKind::kUnknown, config_.unknown_candidates},
      {CandidateKind::kNear, config_.near_candidates}};
  for (const auto& [kind, count] : draws) {
    for (int i = 0; i < count; ++i) {
      take(proposer.Draw(kind), kind);
    }
  }
  m.cramped = m.candidates.size() < config_.cramped_candidates;
  const int aimed = m.candidates.size();
  for (int i = 0; i < config_.far_draws && m.candidates.size() < aimed + config_.far_candidates;
       ++i) {
    take(proposer.Draw(CandidateKind::kFar), CandidateKind::kFar);
  }
  step.numbers.reachable += m.candidates.size();
}

PlanStep Cfnbv::Plan(const PlanInput& input, Rng& rng) {
  Memory& m = *memory_;
  PlanStep step;
  m.residual.clear();
  Refresh(input.map);
  NotePassed(input, step);
  NoteOutcome(input);
  Refresh(input.map);
  CountTargets(input, step);

  const bool nothing_left = NothingLeft(step.numbers);
  int pathless_rounds = 0;
  for (int round = 0; round < config_.rounds && !nothing_left; ++round) {
    Propose(input, rng, round == 0, step);
    const int worthwhile = Evaluate(input);
    step.numbers.worthwhile += worthwhile;
    if (worthwhile == 0) {
      step.numbers.tested += m.candidates.size();
      if (step.numbers.tested >= config_.stop_tests) {
        break;
      }
    } else if (Choose(input, rng, step)) {
      step.goal.id = ++m.last_id;
      m.room_goals += m.last_is_room ? 1 : 0;
      Keep();
      return step;
    } else if (++pathless_rounds == kPathlessRounds) {
      return step;
    } else {
      Refresh(input.map);
    }
  }
  Finish(input, step);
  return step;
}

}  // namespace pipewright
