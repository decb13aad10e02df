// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pipewright::hil {

/// One problem of a QPB1 file, as it stands there:
///
///   minimise 1/2 x'Hx + g'x   subject to   Ae x = be,  l <= Ai x <= u,  lb <= x <= ub
///
/// Matrices row-major. The last slacks() variables are slacks: kept() + k is free and stands only
/// in row soft_row[k] of Ai, with coefficient -1, and in the cost only on H's diagonal.
struct QpbProblem {
  int n = 0;
  bool infeasible = false;  ///< what the file expects
  std::vector<int> soft_row;
  std::vector<double> H, g, Ae, be, Ai, l, u, lb, ub;

  int equalities() const { return static_cast<int>(be.size()); }
  int inequalities() const { return static_cast<int>(l.size()); }
  int slacks() const { return static_cast<int>(soft_row.size()); }
  int kept() const { return n - slacks(); }
};

struct QpbSet {
  bool is_sequence = false;  ///< each problem is the next moment of the one before
  std::vector<QpbProblem> problems;
};

struct QpbResult {
  std::optional<QpbSet> set;  ///< whole and as documented, or nothing
  std::string error;          ///< in words; problems and rows count from 0
};

/// A QPB1 file, little-endian:
///
///   'QPB1', int32 problems, int32 is_sequence (0 or 1); then of each problem
///   int32 n, me, mi, ns, expect (0 feasible, 1 infeasible), soft_row[ns]
///   double H[n][n], g[n], Ae[me][n], be[me], Ai[mi][n], l[mi], u[mi], lb[n], ub[n]
///
/// Limits of 1e30 and beyond are infinite: +-infinity in the result. All else is finite, H is
/// symmetric, a row is softened by one slack at most. Memory follows the size of the file, not what
/// its counts claim.
QpbResult ReadQpb(const std::filesystem::path& path);

}  // namespace pipewright::hil
