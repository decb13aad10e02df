// SPDX-License-Identifier: MIT
#include "ctrl/constraints/row_maker.h"

#include <algorithm>
#include <cmath>

namespace pipewright {
namespace {

constexpr double kNoMotion = 1e-9;  // a row this small moves nothing

/// How much u may still do in a row, m/s: small is urgent.
double Spare(const Row& row) { return row.hi; }
double Spare(const ChanceRow& row) { return row.limit; }

/// Adds row, at the expense of the one with most to spare when there is no room. Joint speeds stay.
template <typename Set, typename R>
int KeepNearest(Set& set, const R& row) {
  if (set.push_back(row)) {
    return 0;
  }
  R* most = nullptr;
  for (R& kept : set) {
    const bool may_go = (kept.key >> 26) != static_cast<int>(RowKind::kJointVelocity);
    if (may_go && (most == nullptr || Spare(kept) > Spare(*most))) {
      most = &kept;
    }
  }
  if (most != nullptr && Spare(*most) > Spare(row)) {
    *most = row;
  }
  return 1;
}

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
    : config_(config), z_(z), out_(out) {}

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
  Keep(row);
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
  out_.dropped += KeepNearest(out_.chance, row);
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
      Keep(row);
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
  Keep(row);
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

void RowMaker::Keep(const Row& row) { out_.dropped += KeepNearest(out_.rows, row); }

void RowMaker::Finish() {
  for (const Row& row : leave_) {
    if (!out_.rows.push_back(row)) {
      return;
    }
  }
}

}  // namespace pipewright
