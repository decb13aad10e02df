// SPDX-License-Identifier: MIT
#include "ctrl/constraints/row_selection.h"

#include <algorithm>

namespace pipewright {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Largest a'u of the box.
double Most(const Controls& a, const ControlBox& box) {
  return a.cwiseProduct(box.lb).cwiseMax(a.cwiseProduct(box.ub)).sum();
}

/// (limit − at_zero) / (most − at_zero)
double Part(double limit, double at_zero, double most) {
  const double room = limit - at_zero;
  const double rise = most - at_zero;
  if (room < 0) {
    return room;
  }
  return rise > 0 ? room / rise : kInfinity;
}

}  // namespace

double HeldPart(const Row& row, const ControlBox& box) {
  return std::min(Part(row.hi, 0, Most(row.a, box)), Part(-row.lo, 0, Most(-row.a, box)));
}

double HeldPart(const ChanceRow& row, const ControlBox& box) {
  const Vector3d center = row.J * ((box.lb + box.ub) / 2);
  const Vector3d radius = row.J.cwiseAbs() * ((box.ub - box.lb) / 2);
  const double most = Most(row.a, box) + box.z * row.cone.UpperBound(center, radius);
  return Part(row.limit, box.z * std::sqrt(std::max(row.cone.c, 0.0)), most);
}

}  // namespace pipewright
