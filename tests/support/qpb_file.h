// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hil/qpb/qpb.h"

namespace pipewright::test {

/// The bytes of a QPB1 file, from what a reader must find in it. Infinities become +-1e30.
class QpbBytes {
 public:
  explicit QpbBytes(const hil::QpbSet& set) {
    bytes_ = "QPB1";
    Int(static_cast<int>(set.problems.size()));
    Int(set.is_sequence ? 1 : 0);
    for (const hil::QpbProblem& p : set.problems) {
      for (const int i : {p.n, p.equalities(), p.inequalities(), p.slacks(), int{p.infeasible}}) {
        Int(i);
      }
      for (const int row : p.soft_row) {
        Int(row);
      }
      for (const auto* a : {&p.H, &p.g, &p.Ae, &p.be, &p.Ai, &p.l, &p.u, &p.lb, &p.ub}) {
        for (const double v : *a) {
          Number(v);
        }
      }
    }
  }

  const std::string& str() const { return bytes_; }

 private:
  void Int(std::int32_t value) { bytes_.append(reinterpret_cast<const char*>(&value), 4); }
  void Number(double value) {
    const double v = value > 1e30 ? 1e30 : value < -1e30 ? -1e30 : value;
    bytes_.append(reinterpret_cast<const char*>(&v), 8);
  }

  std::string bytes_;
};

inline std::string SetBytes(std::vector<hil::QpbProblem> problems, bool is_sequence = false) {
  return QpbBytes(hil::QpbSet{.is_sequence = is_sequence, .problems = std::move(problems)}).str();
}

/// minimise 1/2 x0^2 + 1/2 x1^2 + 3/2 s^2 subject to x1 = 2, x0 - s <= -1, -4 <= x0 + x1 <= 9,
/// x0 >= -5. The optimum is x0 = -3/4, x1 = 2, s = 1/4, where nu = -2 and lambda_0 = 3/4.
inline hil::QpbProblem SoftProblem() {
  constexpr double kInf = 1e30;
  hil::QpbProblem p;
  p.n = 3;
  p.soft_row = {0};
  p.H = {1, 0, 0, 0, 1, 0, 0, 0, 3};
  p.g = {0, 0, 0};
  p.Ae = {0, 1, 0};
  p.be = {2};
  p.Ai = {1, 0, -1, 1, 1, 0};
  p.l = {-kInf, -4};
  p.u = {-1, 9};
  p.lb = {-5, -kInf, -kInf};
  p.ub = {kInf, kInf, kInf};
  return p;
}

/// x0 <= 1 and x0 >= 2: nothing.
inline hil::QpbProblem InfeasibleProblem() {
  hil::QpbProblem p;
  p.n = 1;
  p.infeasible = true;
  p.H = {1};
  p.g = {0};
  p.Ai = {1, 1};
  p.l = {-1e30, 2};
  p.u = {1, 1e30};
  p.lb = {-1e30};
  p.ub = {1e30};
  return p;
}

}  // namespace pipewright::test
