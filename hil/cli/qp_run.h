// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ctrl/qp/qp.h"
#include "hil/qpb/qpb.h"

namespace pipewright::hil {

struct QpOptions {
  std::string file;
  bool warm = false;
  int repeat = 5;
  bool json = false;
};

struct QpAnswer {
  QpStatus status = QpStatus::kInvalid;
  int iterations = 0;
  double us = 0;          ///< the least of all passes
  double kkt = 0;         ///< KktResidual in the file's numbers; kOptimal only
  std::vector<double> x;  ///< in the file's variables; empty when infeasible
  bool as_expected = false;
};

struct QpRun {
  std::string error;  ///< why the set cannot be run, in words; empty when it was
  std::vector<QpAnswer> answers;
  std::uint64_t heap_allocations = 0;  ///< of all solves together
};

/// An optimum with a larger residual is not one, whatever the solver says.
inline constexpr double kQpLargestKkt = 1e-6;

/// Solves every problem `repeat` times, pass after pass, each in the smallest size that holds it;
/// a warm set, in the smallest that holds all. Every pass begins cold: all do the same work, and a
/// warm set's spread is that of the problems after the first.
QpRun RunQpSet(const QpbSet& set, const QpOptions& options);

bool Passed(const QpRun& run);

nlohmann::ordered_json QpJson(const QpbSet& set, const QpRun& run, const QpOptions& options);

/// The same for people: a line a problem, then the set's.
std::string QpTable(const QpbSet& set, const QpRun& run, const QpOptions& options);

}  // namespace pipewright::hil
