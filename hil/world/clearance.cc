// SPDX-License-Identifier: MIT
#include "hil/world/clearance.h"

#include <algorithm>
#include <cassert>

#include "hil/world/convex_distance.h"

namespace pipewright::hil {

ClearanceMeter::ClearanceMeter(const std::vector<Solid>& solids, const RobotBodies& robot)
    : solids_(solids), robot_(robot), X_WG_(robot.bodies.size(), Isometry3d::Identity()) {
  for (const Body& body : robot.bodies) {
    radius_m_.push_back(BoundingRadius(body.shape));
  }
  const int bodies = static_cast<int>(robot.bodies.size());
  for (int i = 0; i < bodies; ++i) {
    for (int j = i + 1; j < bodies; ++j) {
      const int a = robot.bodies[i].group;
      const int b = robot.bodies[j].group;
      const bool meet = std::any_of(
          robot.adjacent_groups.begin(), robot.adjacent_groups.end(), [&](const auto& pair) {
            return (pair.first == a && pair.second == b) || (pair.first == b && pair.second == a);
          });
      if (a != b && !meet) {
        self_pairs_.emplace_back(i, j);
      }
    }
  }
}

void ClearanceMeter::Place(std::span<const Isometry3d> X_WL) {
  assert(static_cast<int>(X_WL.size()) >= robot_.links);
  for (std::size_t i = 0; i < robot_.bodies.size(); ++i) {
    X_WG_[i] = X_WL[robot_.bodies[i].link] * robot_.bodies[i].X_LG;
  }
}

bool ClearanceMeter::Exempt(int body, int solid) const {
  return solids_[solid].ground && robot_.bodies[body].group == 0;
}

double ClearanceMeter::SolidLowerBound(int body, int solid) const {
  const Vector3d& center = X_WG_[body].translation();
  const Solid& s = solids_[solid];
  if (s.kind == SolidKind::kMesh) {
    const Vector3d gap = (s.mesh->lo_W() - center).cwiseMax(center - s.mesh->hi_W());
    return gap.cwiseMax(0).norm() - radius_m_[body];
  }
  return Distance(s, center) - radius_m_[body];
}

void ClearanceMeter::Count(int body, int other, bool self) {
  const std::pair<int, int> pair(body, self ? -1 - other : other);
  in_contact_.push_back(pair);
  if (std::find(was_in_contact_.begin(), was_in_contact_.end(), pair) != was_in_contact_.end()) {
    return;
  }
  ++episodes_;
  const std::string& name = self ? robot_.bodies[other].name : solids_[other].name;
  const std::string text = robot_.bodies[body].name + " - " + name;
  if (std::find(touched_.begin(), touched_.end(), text) == touched_.end()) {
    touched_.push_back(text);
  }
}

void ClearanceMeter::MeasureKind(std::vector<Candidate>& candidates, bool self,
                                 NearestPair& nearest, Clearance& result) {
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.lower_m < b.lower_m; });
  for (const Candidate& c : candidates) {
    if (c.lower_m > nearest.distance_m) {
      break;
    }
    const Shape& shape = robot_.bodies[c.body].shape;
    const double distance_m =
        self ? ConvexDistance(shape, X_WG_[c.body], robot_.bodies[c.other].shape, X_WG_[c.other],
                              nearest.distance_m)
             : Distance(solids_[c.other], shape, X_WG_[c.body], nearest.distance_m);
    if (distance_m < nearest.distance_m) {
      nearest = {distance_m, c.body, c.other};
    }
    if (distance_m <= 0) {
      ++result.contacts;
      Count(c.body, c.other, self);
    }
  }
}

Clearance ClearanceMeter::Measure(std::span<const Isometry3d> X_WL) {
  Place(X_WL);
  plane_candidates_.clear();
  pipe_candidates_.clear();
  self_candidates_.clear();
  for (int body = 0; body < static_cast<int>(robot_.bodies.size()); ++body) {
    for (int solid = 0; solid < static_cast<int>(solids_.size()); ++solid) {
      if (!Exempt(body, solid)) {
        (IsPipe(solids_[solid]) ? pipe_candidates_ : plane_candidates_)
            .push_back({SolidLowerBound(body, solid), body, solid});
      }
    }
  }
  for (const auto& [i, j] : self_pairs_) {
    const double centers_m = (X_WG_[i].translation() - X_WG_[j].translation()).norm();
    self_candidates_.push_back({centers_m - radius_m_[i] - radius_m_[j], i, j});
  }
  std::swap(in_contact_, was_in_contact_);
  in_contact_.clear();
  Clearance result;
  MeasureKind(plane_candidates_, false, result.plane, result);
  MeasureKind(pipe_candidates_, false, result.pipe, result);
  MeasureKind(self_candidates_, true, result.self, result);
  return result;
}

bool ClearanceMeter::Touches(std::span<const Isometry3d> X_WL, int only_group) {
  Place(X_WL);
  for (int body = 0; body < static_cast<int>(robot_.bodies.size()); ++body) {
    if (only_group >= 0 && robot_.bodies[body].group != only_group) {
      continue;
    }
    for (int solid = 0; solid < static_cast<int>(solids_.size()); ++solid) {
      if (!Exempt(body, solid) && SolidLowerBound(body, solid) <= 0 &&
          Distance(solids_[solid], robot_.bodies[body].shape, X_WG_[body], 0) <= 0) {
        return true;
      }
    }
  }
  return only_group < 0 &&
         std::any_of(self_pairs_.begin(), self_pairs_.end(), [&](const auto& pair) {
           const auto& [i, j] = pair;
           const double reach_m = radius_m_[i] + radius_m_[j];
           return (X_WG_[i].translation() - X_WG_[j].translation()).squaredNorm() <=
                      reach_m * reach_m &&
                  ConvexDistance(robot_.bodies[i].shape, X_WG_[i], robot_.bodies[j].shape, X_WG_[j],
                                 0) <= 0;
         });
}

}  // namespace pipewright::hil
