// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "ctrl/robot_program/control_task.h"

namespace pipewright::bench {

/// What a control cycle did, which is the same in every pass over the same cycles, and how long.
struct CycleFigures {
  static constexpr int kManyRows = 120;

  float us = 0;      ///< in the first pass
  float qp_us = 0;   ///< likewise
  float own_us = 0;  ///< the least of all passes
  bool preempted = false;
  std::int16_t rows = 0;  ///< of the QP as it is first posed: one for each chance row
  std::int16_t dropped = 0;
  std::int16_t rounds = 0;
  std::int16_t iterations = 0;

  bool many_rows() const { return rows >= kManyRows; }
};

/// The figures of a run: the first pass's, and the least time of each cycle over all passes, for
/// what a cycle takes in every pass is its own, and what it takes in one alone the machine's.
class ControlFigures {
 public:
  void Reserve(int cycles) { cycles_.reserve(static_cast<std::size_t>(cycles)); }

  /// A cycle of the first pass.
  void Add(const ControlReport& report, double us, bool preempted);

  /// Cycle i, from 0, of a later pass. False: it is not what it was.
  bool Repeat(std::size_t i, const ControlReport& report, double us);

  std::size_t cycles() const { return cycles_.size(); }
  int many_rows() const { return many_rows_; }  ///< cycles
  nlohmann::ordered_json ToJson() const;

 private:
  std::vector<CycleFigures> cycles_;
  int many_rows_ = 0;
  int moving_ = 0;
  int clamped_ = 0;      ///< cycles in which a hard row was at its clamp
  int invalid_ = 0;      ///< cycles without a valid state: the law did nothing
  double box_part_ = 1;  ///< the least
  int cap_hits_ = 0;
  int not_optimal_ = 0;  ///< cap hits and whatever else is no optimum
  int fallbacks_ = 0;
};

}  // namespace pipewright::bench
