// SPDX-License-Identifier: MIT
#include "plan/cfnbv/cfnbv.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "perception/map/distance_field.h"
#include "perception/map/voxel_grid.h"
#include "plan/cfnbv/failures.h"
#include "plan/cfnbv/proposals.h"
#include "plan/motion/edge.h"
#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

constexpr int kMaxKept = 24;
constexpr int kMaxCandidates = 1000 + kMaxKept;
constexpr double kOneStallFactor = 0.3;
constexpr int kStallsUntilRefused = 2;
/// Fewer tests than this share of stop_tests say too little to call W complete.
constexpr double kTestsShare = 0.25;
/// Rounds in one step whose every worthwhile view lacked a path, until the step gives in.
constexpr int kPathlessRounds = 3;
constexpr double kMissChance = 0.01;
/// Samples of a way: the probe covers at every step, the camera counts at every fifth.
constexpr double kWayStep_s = 0.2;
constexpr int kStepsPerLook = 5;

bool NothingLeft(const PlanNumbers& n) {
  return n.unknown_targets == 0 && n.uncovered_targets == 0 && n.surface_targets == 0;
}

double StallFactor(int stalls) { return stalls == 0 ? 1 : kOneStallFactor; }

}  // namespace

struct Cfnbv::Candidate {
  Configuration q = Configuration::Zero();
  Viewpoint view;
  CandidateKind kind = CandidateKind::kUniform;
  ViewGain gain;
  double weighted = 0;  ///< (23) and room, nats
  double score = 0;     ///< nats a second, by the least time; 0: not to be taken
  int stalls = 0;       ///< near the view
  bool room = false;    ///< worth the way for the room it gives only
};

struct Cfnbv::Memory {
  Memory(const CfnbvConfig& config, const MapConfig& map)
      : gains(config.gain, map),
        surface(map),
        motion(config.motion),
        camera(LatticeCameraRays(config.gain)),
        failures(gains.workspace_voxels(), config.tries_per_voxel, config.stall_radius_m) {
    residual.reserve(static_cast<std::size_t>(gains.workspace_voxels()));
  }

  GainEvaluator gains;
  SurfaceToCover surface;
  Vector3d passed[kMaxPassed];  ///< places of the probe since the last plan
  int passed_count = 0;         ///< ever; the newest kMaxPassed are held
  MotionPlanner motion;
  RaySet camera;
  Failures failures;
  FixedVector<Candidate, kMaxCandidates> candidates;
  FixedVector<Configuration, kMaxKept> kept;
  std::vector<VoxelIndex> residual;
  EdgeSpeeds speeds = SpeedsOf(TracerUf7());
  Viewpoint last_view;
  std::uint32_t last_id = 0;  ///< of the last goal; 0: none
  bool last_is_room = false;
  int room_goals = 0;  ///< since W's map last grew by forget_voxels
  int known_at_pathless = 0;
  MotionPlanner::Path path;
};

Cfnbv::Cfnbv(const CfnbvConfig& config, const MapConfig& map)
    : config_(config), memory_(std::make_unique<Memory>(config, map)) {
  assert(Valid(config));
}

Cfnbv::~Cfnbv() = default;

std::span<const VoxelIndex> Cfnbv::NewResidual() const { return memory_->residual; }

/// Learns from how the last goal ended. `gains` must be fresh.
void Cfnbv::NoteOutcome(const PlanInput& input) {
  Memory& m = *memory_;
  switch (input.outcome) {
    case GoalState::kReached:
      m.gains.Tally(ViewpointOf(input.q), m.camera, m.failures.unsettled());
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

/// Gains and scores of the candidates. @returns how many are worth the way
int Cfnbv::Evaluate(const PlanInput& input) {
  Memory& m = *memory_;
  const bool cramped =
      m.candidates.size() < config_.cramped_candidates && m.room_goals < config_.room_goals;
  int count = 0;
  for (Candidate& c : m.candidates) {
    c.view = ViewpointOf(c.q);
    c.gain = m.gains.EvaluateExact(c.view, m.camera);
    c.weighted = WeightedGain(config_.gain, c.gain);
    bool worthwhile = c.gain.unknown_voxels >= config_.stop_unknown ||
                      c.gain.uncovered_voxels >= config_.stop_uncovered;
    if (cramped) {
      const int room = m.gains.RoomCount(c.view.X_WS, m.camera, config_.room_range_m);
      c.room = !worthwhile && room >= config_.stop_room;
      c.weighted += config_.room_share * room;
      worthwhile = worthwhile || c.room;
    }
    c.stalls = worthwhile ? m.failures.StallsNear(c.view) : 0;
    if (!worthwhile || c.stalls >= kStallsUntilRefused) {
      c.score = 0;
      continue;
    }
    const double least_s = Edge(input.q, c.q, m.speeds).duration_s();
    c.score = c.weighted / (config_.overhead_s + least_s) * StallFactor(c.stalls);
    ++count;
  }
  return count;
}

/// What camera and probe meet from the path's start to its end, each voxel once.
ViewGain Cfnbv::WayGain(const MotionPlanner::Path& path) {
  Memory& m = *memory_;
  ViewGain sum;
  const auto add = [&](const ViewGain& gain) {
    sum.visual_nats += gain.visual_nats;
    sum.coverage_nats += gain.coverage_nats;
    sum.unknown_voxels += gain.unknown_voxels;
    sum.uncovered_voxels += gain.uncovered_voxels;
  };
  m.gains.BeginWay();
  int sample = 0;
  for (int i = 0; i + 1 < path.size(); ++i) {
    const Edge edge(path[i], path[i + 1], m.speeds);
    const int steps = std::max(1, static_cast<int>(edge.duration_s() / kWayStep_s));
    for (int k = 1; k <= steps; ++k, ++sample) {
      const Viewpoint view = ViewpointOf(edge.At(static_cast<double>(k) / steps));
      const bool look = sample % kStepsPerLook == 0 || (i + 2 == path.size() && k == steps);
      add(look ? m.gains.NextOnWay(view, m.camera) : m.gains.NextOnWay(view.p_WP));
    }
  }
  return sum;
}

/// Plans ways to the candidates of the best scores, and takes the one that gains most a second over
/// its true time. Views without a path are tallied.
bool Cfnbv::Choose(const PlanInput& input, Rng& rng, PlanStep& step) {
  Memory& m = *memory_;
  const Surroundings around{input.field, input.map, input.scene};
  double best_score = 0;
  for (int i = 0; i < config_.paths; ++i) {
    Candidate& c =
        *std::max_element(m.candidates.begin(), m.candidates.end(),
                          [](const Candidate& a, const Candidate& b) { return a.score < b.score; });
    if (c.score <= 0) {
      break;
    }
    double duration_s = 0;
    ++step.numbers.paths_tried;
    const Status status = m.motion.Plan(around, input.q, c.q, rng, m.path, &duration_s);
    if (status == Status::kOk) {
      const ViewGain way = WayGain(m.path);
      const double extra = c.weighted - WeightedGain(config_.gain, c.gain);
      const double score = (WeightedGain(config_.gain, way) + extra) /
                           (config_.overhead_s + duration_s) * StallFactor(c.stalls);
      if (score > best_score) {
        best_score = score;
        Accept(c, way, duration_s, step);
      }
    } else {
      m.gains.Tally(c.view, m.camera, m.failures.pathless());
      step.status = status == Status::kFull ? Status::kFull : step.status;
    }
    c.score = 0;
  }
  return best_score > 0;
}

void Cfnbv::Accept(const Candidate& c, const ViewGain& way, double duration_s, PlanStep& step) {
  Memory& m = *memory_;
  step.decision = PlanDecision::kGoal;
  step.goal.p_WS = c.view.X_WS.translation();
  step.goal.z_WS = c.view.X_WS.linear().col(2);
  step.goal.path = m.path;
  step.numbers.kind = c.kind;
  step.numbers.gain_visual = way.visual_nats;
  step.numbers.gain_coverage = way.coverage_nats;
  step.numbers.gain_weighted = WeightedGain(config_.gain, way);
  step.numbers.duration_s = duration_s;
  m.last_view = c.view;
  m.last_is_room = c.room;
}

/// Remembers the best configurations that were not tried.
void Cfnbv::Keep() {
  Memory& m = *memory_;
  m.kept.clear();
  while (!m.kept.full()) {
    const auto best =
        std::max_element(m.candidates.begin(), m.candidates.end(),
                         [](const Candidate& a, const Candidate& b) { return a.score < b.score; });
    if (best == m.candidates.end() || best->score <= 0 || !m.kept.push_back(best->q)) {
      return;
    }
    best->score = 0;
  }
}

void Cfnbv::CountTargets(const PlanInput& input, PlanStep& step) {
  Memory& m = *memory_;
  const MapCounts& counts = input.map.counts();
  step.numbers.unknown_targets = static_cast<int>(m.gains.Unknown().size());
  step.numbers.uncovered_targets = static_cast<int>(m.gains.Uncovered().size());
  step.numbers.surface_targets = static_cast<int>(m.surface.patches().size());
  step.numbers.given_up = counts.occupied - counts.covered - step.numbers.uncovered_targets;
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
      {CandidateKind::kNear, config_.near_candidates},
      {CandidateKind::kFar, config_.far_candidates}};
  for (const auto& [kind, count] : draws) {
    for (int i = 0; i < count; ++i) {
      take(proposer.Draw(kind), kind);
    }
  }
  step.numbers.reachable += m.candidates.size();
}

/// Nothing worthwhile is left: says what that means, and gives up the unknown voxels.
void Cfnbv::Finish(const PlanInput& input, PlanStep& step) {
  const MapCounts& counts = input.map.counts();
  const int tested = step.numbers.tested;
  const bool enough = NothingLeft(step.numbers) || tested >= kTestsShare * config_.stop_tests;
  const int known = counts.free + counts.occupied;
  if (tested > 0) {
    step.numbers.share_bound = 1 - std::pow(kMissChance, 1.0 / tested);
  }
  if (!enough || known < config_.complete_known_share * counts.total ||
      counts.covered < config_.complete_covered_share * counts.occupied) {
    return;
  }
  step.decision = PlanDecision::kComplete;
  const VoxelIndex& lo = input.map.config().workspace_lo;
  const VoxelIndex& hi = input.map.config().workspace_hi;
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        const VoxelIndex v{x, y, z};
        if (input.map.State(v) == VoxelState::kUnknown && !input.map.Residual(v)) {
          memory_->residual.push_back(v);
        }
      }
    }
  }
  step.numbers.residual_new = static_cast<int>(memory_->residual.size());
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
