// SPDX-License-Identifier: MIT
// Which candidate becomes the goal: gain a second over the true time of a way that is free.
#include <algorithm>

#include "perception/map/distance_field.h"
#include "plan/cfnbv/cfnbv_memory.h"
#include "plan/cfnbv/proposals.h"
#include "plan/motion/edge.h"

namespace pipewright {
namespace {

constexpr double kOneStallFactor = 0.3;
constexpr int kStallsUntilRefused = 2;
/// Samples of a way: the probe covers at every step, the camera counts at every fifth.
constexpr double kWayStep_s = 0.2;
constexpr int kStepsPerLook = 5;

double StallFactor(int stalls) { return stalls == 0 ? 1 : kOneStallFactor; }

}  // namespace

/// Gains and scores of the candidates. @returns how many are worth the way
int Cfnbv::Evaluate(const PlanInput& input) {
  Memory& m = *memory_;
  const bool cramped = m.cramped && m.room_goals < config_.room_goals;
  int count = 0;
  for (Candidate& c : m.candidates) {
    c.view = ViewpointOf(c.q);
    const RaySet& open = m.OpenAt(c.q);
    c.gain = m.gains.EvaluateExact(c.view, open);
    c.weighted = WeightedGain(config_.gain, c.gain);
    bool worthwhile = c.gain.unknown_voxels >= config_.stop_unknown ||
                      c.gain.uncovered_voxels >= config_.stop_uncovered;
    if (cramped) {
      const int room = m.gains.RoomCount(c.view.X_WS, open, config_.room_range_m);
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

/// Calls visit(q, look) along the path; where look is true, the camera counts too.
template <typename Visit>
void Cfnbv::WalkWay(const MotionPlanner::Path& path, Visit visit) {
  memory_->gains.BeginWay();
  int sample = 0;
  for (int i = 0; i + 1 < path.size(); ++i) {
    const Edge edge(path[i], path[i + 1], memory_->speeds);
    const int steps = std::max(1, static_cast<int>(edge.duration_s() / kWayStep_s));
    for (int k = 1; k <= steps; ++k, ++sample) {
      const bool look = sample % kStepsPerLook == 0 || (i + 2 == path.size() && k == steps);
      visit(edge.At(static_cast<double>(k) / steps), look);
    }
  }
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
  WalkWay(path, [&](const Configuration& q, bool look) {
    const Viewpoint view = ViewpointOf(q);
    add(look ? m.gains.NextOnWay(view, m.OpenAt(q)) : m.gains.NextOnWay(view.p_WP));
  });
  return sum;
}

/// Tallies what the way to q should have settled, and has not.
void Cfnbv::TallyWay(const Configuration& q) {
  Memory& m = *memory_;
  const auto tally = [&](const Configuration& at) {
    m.gains.TallyOnWay(ViewpointOf(at), m.OpenAt(at), m.failures.unsettled());
  };
  WalkWay(m.last_path, [&](const Configuration& at, bool look) {
    if (look) {
      tally(at);
    }
  });
  tally(q);
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
      m.gains.Tally(c.view, m.OpenAt(c.q), m.failures.pathless());
      m.room_goals += c.room ? 1 : 0;
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
  m.last_path = m.path;
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

}  // namespace pipewright
