// SPDX-License-Identifier: MIT
#include "ctrl/constraints/row_maker.h"

#include <algorithm>
#include <cmath>

namespace pipewright {
namespace {

constexpr double kNoMotion = 1e-9;  // a row this small moves nothing

}  // namespace

double HoldBuffer(const Mat<3, kControls>& J, const Controls& u_max, double period_s) {
  double nearer_radps = u_max(1);
  double bound_mps2 = u_max(1) * std::sqrt(J.col(1).squaredNorm()) * u_max(1) +
                      2 * u_max(0) * std::sqrt(J.col(0).squaredNorm()) * u_max(1);
  for (int i = 2; i < kControls; ++i) {
    bound_mps2 += u_max(i) * std::sqrt(J.col(i).squaredNorm()) * (u_max(i) + 2 * nearer_radps);
    nearer_radps += u_max(i);
  }
  return period_s / 2 * bound_mps2;
}

RowMaker::RowMaker(const ConstraintConfig& config, double z, ConstraintSet& out)
    : config_(config),
      z_(z),
      out_(out),
      plain_(out.rows, {out.lb, out.ub, z}),
      chance_(out.chance, {out.lb, out.ub, z}) {}

void RowMaker::Distance(const Pair& pair, const Controls& g) {
  if (g.squaredNorm() < kNoMotion * kNoMotion) {
    return;
  }
  Row row;
  row.a = -g;
  row.hi = pair.eta_1ps * pair.spare_m - pair.buffer_mps;
  row.price = config_.Price(pair.kind);
  row.key = RowKey(pair.kind, pair.first, pair.second);
  const bool hard = row.price == 0;
  row.hi = std::max(row.hi, hard ? 0 : -config_.recovery_mps);
  if (hard && pair.spare_m < 0) {
    ++out_.clamped;
    Leave(pair, g);
  }
  plain_.Add(row);
}

void RowMaker::Chance(const Pair& pair, const Vector3d& gradient_W, const RobotPoint& point,
                      const VelocityCone& cone) {
  ChanceRow row;
  row.a = -(point.J.transpose() * gradient_W);
  if (row.a.squaredNorm() < kNoMotion * kNoMotion) {
    return;
  }
  row.b = pair.eta_1ps * pair.spare_m;
  row.price = config_.Price(pair.kind);
  row.key = RowKey(pair.kind, pair.first, pair.second);
  row.cone = cone;
  row.J = point.J;
  const double standing = z_ * std::sqrt(std::max(cone.c, 0.0));
  const bool hard = row.price == 0;
  row.limit = std::max(row.b - pair.buffer_mps, hard ? standing : standing - config_.recovery_mps);
  if (hard && row.b < standing) {
    ++out_.clamped;
    Leave({pair.kind, pair.first, pair.second, (row.b - standing) / pair.eta_1ps, pair.eta_1ps, 0},
          -row.a);
  }
  chance_.Add(row);
}

void RowMaker::Creep(const Pair& pair, const RobotPoint& point) {
  ++out_.inside;
  for (int i = 0; i < 3; ++i) {
    Row row;
    row.a = point.J.row(i).transpose();
    row.hi = config_.recovery_mps;
    row.lo = -row.hi;
    row.price = config_.Price(pair.kind);
    row.key = RowKey(pair.kind, pair.first, static_cast<std::uint32_t>(16 + i));
    if (row.a.squaredNorm() >= kNoMotion * kNoMotion) {
      plain_.Add(row);
    }
  }
}

void RowMaker::JointSpeed(int control, double speed_radps) {
  Row row;
  row.a(control) = 1;
  row.lo = -speed_radps;
  row.hi = speed_radps;
  row.price = config_.Price(RowKind::kJointVelocity);
  row.key = RowKey(RowKind::kJointVelocity, control, 0);
  plain_.Add(row);
}

void RowMaker::Leave(const Pair& pair, const Controls& g) {
  Row row;
  row.a = -g;
  row.hi = -std::min(config_.recovery_mps, -pair.eta_1ps * pair.spare_m);
  row.price = config_.Price(RowKind::kRecovery);
  row.key = RowKey(RowKind::kRecovery, pair.first,
                   pair.second * kRowKinds + static_cast<std::uint32_t>(pair.kind));
  if (row.hi < 0 && !leave_.full()) {
    (void)leave_.push_back(row);
  }
}

void RowMaker::Finish() {
  out_.dropped = plain_.dropped() + chance_.dropped();
  out_.box_part = std::clamp(std::min(plain_.held(), chance_.held()), 0.0, 1.0);
  if (out_.box_part < 1) {
    out_.lb *= out_.box_part;
    out_.ub *= out_.box_part;
    out_.reach_lb = out_.reach_lb.cwiseMax(out_.lb).cwiseMin(out_.ub);
    out_.reach_ub = out_.reach_ub.cwiseMax(out_.lb).cwiseMin(out_.ub);
  }
  for (const Row& row : leave_) {
    if (!out_.rows.push_back(row)) {
      return;
    }
  }
}

}  // namespace pipewright
