// SPDX-License-Identifier: MIT
#include "ctrl/constraints/self_rows.h"

#include <algorithm>
#include <cmath>

namespace pipewright {
namespace {

struct Segment {
  Vector3d a_W;
  Vector3d b_W;
};

/// d' = n'(J_Q u − J_R u) for the points Q, R where two bodies are nearest.
void AddPair(const RowContext& c, int index, std::uint32_t list, int body_q, const Vector3d& p_WQ,
             int body_r, const Vector3d& p_WR, double radii_m, RowMaker& maker,
             Clearances& clearance) {
  const PointDistance distance = PointToPoint(p_WQ, p_WR);
  clearance.self_m = std::min(clearance.self_m, distance.d_m - radii_m);
  const double spare_m = distance.d_m - radii_m - c.config.self_margin_m;
  if (spare_m > c.config.consider_self_m) {
    return;
  }
  RobotPoint relative;
  relative.J =
      c.kinematics.PointJacobianAt(body_q, p_WQ) - c.kinematics.PointJacobianAt(body_r, p_WR);
  relative.buffer_mps = HoldBuffer(relative.J, c.u_max, c.config.period_s);
  const RowMaker::Pair pair{RowKind::kSelf,     index, list, spare_m, c.config.eta_self_1ps,
                            relative.buffer_mps};
  if (distance.gradient_W.isZero(0)) {
    maker.Creep(pair, relative);
    return;
  }
  maker.Distance(pair, relative.J.transpose() * distance.gradient_W);
}

}  // namespace

void AddSelfRows(const RowContext& c, RowMaker& maker, Clearances& clearance) {
  const RobotShapes& shapes = c.shapes;
  FixedVector<Segment, RobotShapes::kMaxShapes> segments;
  for (const BodyCapsule& capsule : shapes.capsules) {
    (void)segments.push_back({c.kinematics.Point(capsule.body, capsule.p_LA),
                              c.kinematics.Point(capsule.body, capsule.p_LB)});
  }
  int index = 0;
  for (const IndexPair& pair : shapes.capsule_pairs) {
    const Segment& q = segments[pair.first];
    const Segment& r = segments[pair.second];
    const SegmentPair nearest = SegmentToSegment(q.a_W, q.b_W, r.a_W, r.b_W);
    AddPair(c, index++, 0, shapes.capsules[pair.first].body, q.a_W + nearest.s * (q.b_W - q.a_W),
            shapes.capsules[pair.second].body, r.a_W + nearest.t * (r.b_W - r.a_W),
            shapes.capsules[pair.first].r_m + shapes.capsules[pair.second].r_m, maker, clearance);
  }
  index = 0;
  for (const IndexPair& pair : shapes.box_pairs) {
    const BodyShape& box = shapes.boxes[pair.second];
    const Isometry3d X_WG = c.kinematics.X_WL(box.body) * box.X_LG;
    const Segment& q = segments[pair.first];
    const BoxPair nearest = SegmentToBox(q.a_W, q.b_W, X_WG, box.half_m);
    AddPair(c, index++, 1, shapes.capsules[pair.first].body, nearest.p_WSegment, box.body,
            nearest.p_WBox, shapes.capsules[pair.first].r_m, maker, clearance);
  }
}

}  // namespace pipewright
