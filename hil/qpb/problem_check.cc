// SPDX-License-Identifier: MIT
#include "hil/qpb/problem_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pipewright::hil {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kAsymmetry = 1e-12;  ///< of H's largest number

/// The first entry that is no finite number. `columns` of 0: the array is a vector.
std::string FiniteError(const std::vector<double>& values, const char* name, int columns) {
  const auto bad =
      std::find_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); });
  if (bad == values.end()) {
    return "";
  }
  const auto at = bad - values.begin();
  const std::string where = columns > 0
                                ? fmt::format("{}[{}][{}]", name, at / columns, at % columns)
                                : fmt::format("{}[{}]", name, at);
  return fmt::format("{} is {}, not a finite number", where, *bad);
}

std::string LimitError(const std::vector<double>& values, const char* name, double never) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i]) || values[i] == never) {
      return fmt::format("{}[{}] is {}, which is no limit", name, i, values[i]);
    }
  }
  return "";
}

std::string NumberError(const QpbProblem& p) {
  for (const std::string& error :
       {FiniteError(p.H, "H", p.n), FiniteError(p.g, "g", 0), FiniteError(p.Ae, "Ae", p.n),
        FiniteError(p.be, "be", 0), FiniteError(p.Ai, "Ai", p.n), LimitError(p.l, "l", kInf),
        LimitError(p.u, "u", -kInf), LimitError(p.lb, "lb", kInf), LimitError(p.ub, "ub", -kInf)}) {
    if (!error.empty()) {
      return error;
    }
  }
  return "";
}

std::string SymmetryError(const QpbProblem& p) {
  double largest = 0;
  for (const double h : p.H) {
    largest = std::max(largest, std::fabs(h));
  }
  for (int i = 0; i < p.n; ++i) {
    for (int j = 0; j < i; ++j) {
      if (std::fabs(p.H[i * p.n + j] - p.H[j * p.n + i]) > kAsymmetry * largest) {
        return fmt::format("H is not symmetric: H[{}][{}] is {}, H[{}][{}] is {}", i, j,
                           p.H[i * p.n + j], j, i, p.H[j * p.n + i]);
      }
    }
  }
  return "";
}

/// Of the column of variable s in a matrix of rows, every entry but the one in row `except`.
bool StandsElsewhere(const std::vector<double>& rows, int n, int s, int except) {
  const int count = static_cast<int>(rows.size()) / n;
  for (int i = 0; i < count; ++i) {
    if (i != except && rows[i * n + s] != 0) {
      return true;
    }
  }
  return false;
}

std::string SoftRowError(const QpbProblem& p, int k) {
  const int row = p.soft_row[k];
  if (row < 0 || row >= p.inequalities()) {
    return fmt::format("soft_row[{}] is {}; there are {} rows in Ai", k, row, p.inequalities());
  }
  const auto earlier = p.soft_row.begin() + k;
  if (std::find(p.soft_row.begin(), earlier, row) != earlier) {
    return fmt::format("soft_row[{}] is {}, which another slack softens already", k, row);
  }
  return "";
}

std::string SlackError(const QpbProblem& p, int k) {
  const int s = p.kept() + k;
  const int row = p.soft_row[k];
  const std::string slack = fmt::format("variable {}, the slack of row {} of Ai, ", s, row);
  if (p.Ai[row * p.n + s] != -1) {
    return slack + fmt::format("has coefficient {} there, not -1", p.Ai[row * p.n + s]);
  }
  if (StandsElsewhere(p.Ai, p.n, s, row) || StandsElsewhere(p.Ae, p.n, s, -1)) {
    return slack + "stands in another row too";
  }
  if (StandsElsewhere(p.H, p.n, s, s)) {
    return slack + "is coupled to another variable by H";
  }
  const double price = p.H[s * p.n + s];
  if (!(price > 0 && std::isnormal(price))) {  // its inverse must be a number
    return slack + fmt::format("has the price {}, not a positive one", price);
  }
  if (p.g[s] != 0) {
    return slack + fmt::format("has the linear cost {}, not 0", p.g[s]);
  }
  if (p.lb[s] != -kInf || p.ub[s] != kInf) {
    return slack + "is bounded, not free";
  }
  return "";
}

}  // namespace

std::string ProblemError(const QpbProblem& p) {
  std::string error = NumberError(p);
  if (error.empty()) {
    error = SymmetryError(p);
  }
  for (int k = 0; error.empty() && k < p.slacks(); ++k) {
    error = SoftRowError(p, k);
  }
  for (int k = 0; error.empty() && k < p.slacks(); ++k) {
    error = SlackError(p, k);
  }
  return error;
}

}  // namespace pipewright::hil
