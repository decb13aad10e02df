// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "ctrl/qp/qp.h"
#include "hil/qpb/kkt.h"
#include "hil/qpb/qpb.h"

namespace pipewright::hil {

/// What one call of Solve took, and nothing around it.
struct QpMeasured {
  QpStatus status = QpStatus::kInvalid;
  int iterations = 0;
  double us = 0;
  std::uint64_t allocations = 0;
};

/// The solver compiled for one size, behind a door that is the same for all.
class SizedQp {
 public:
  virtual ~SizedQp() = default;
  virtual int variables() const = 0;
  virtual int rows() const = 0;
  virtual void Forget() = 0;
  /// Takes over every number of a problem that fits, then solves it.
  virtual QpMeasured Solve(const QpbProblem& p) = 0;
  /// Where the last solve of p ended.
  virtual QpbPoint Point(const QpbProblem& p) const = 0;
};

/// By variables, then by rows. Room for rows that are not there costs a solve up to a tenth of its
/// time, room for variables more: hence several widths, and two capacities for all but the widest.
using QpSizes = std::vector<std::unique_ptr<SizedQp>>;

void AddQpSizes5(QpSizes& sizes);
void AddQpSizes10(QpSizes& sizes);
void AddQpSizes20(QpSizes& sizes);
void AddQpSizes32(QpSizes& sizes);

}  // namespace pipewright::hil
