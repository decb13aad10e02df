// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "ctrl/qp/qp.h"

namespace pipewright::test {

/// One problem of a QPB1 file, as it stands there:
///
///   minimise 1/2 x'Hx + g'x   subject to   Ae x = be,  l <= Ai x <= u,  lb <= x <= ub
///
/// Matrices row-major, infinity +-1e30. The last soft_row.size() variables are slacks: n - ns + k
/// is free and stands only in row soft_row[k] of Ai, with coefficient -1.
struct QpbProblem {
  int n = 0;
  bool infeasible = false;
  std::vector<int> soft_row;
  std::vector<double> H, g, Ae, be, Ai, l, u, lb, ub;

  int equalities() const { return static_cast<int>(be.size()); }
  int inequalities() const { return static_cast<int>(l.size()); }
  int slacks() const { return static_cast<int>(soft_row.size()); }
};

struct QpbSet {
  bool is_sequence = false;  ///< each problem is the next moment of the one before
  std::vector<QpbProblem> problems;
};

/// Nothing when the file is not there, is cut short or is not QPB1. Little-endian hosts.
inline std::optional<QpbSet> ReadQpb(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  std::size_t at = 0;
  bool good = true;
  const auto take = [&](void* to, std::size_t size) {
    good = good && size <= bytes.size() - at;
    if (good && size > 0) {
      std::memcpy(to, bytes.data() + at, size);
      at += size;
    }
  };
  const auto count = [&] {
    std::int32_t value = 0;
    take(&value, sizeof value);
    good = good && value >= 0 && value < 1 << 20;
    return good ? value : 0;
  };
  const auto numbers = [&](int size) {
    std::vector<double> values(static_cast<std::size_t>(size));
    take(values.data(), values.size() * sizeof(double));
    for (double& v : values) {
      v = v >= 1e30 ? kInfinity : v <= -1e30 ? -kInfinity : v;
    }
    return values;
  };
  char magic[4] = {};
  take(magic, 4);
  good = good && std::memcmp(magic, "QPB1", 4) == 0;
  const int problems = count();
  QpbSet set{.is_sequence = count() != 0, .problems = {}};
  for (int k = 0; good && k < problems; ++k) {
    QpbProblem p;
    p.n = count();
    const int me = count();
    const int mi = count();
    const int ns = count();
    p.infeasible = count() != 0;
    for (int i = 0; i < ns; ++i) {
      p.soft_row.push_back(count());
    }
    p.H = numbers(p.n * p.n);
    p.g = numbers(p.n);
    p.Ae = numbers(me * p.n);
    p.be = numbers(me);
    p.Ai = numbers(mi * p.n);
    p.l = numbers(mi);
    p.u = numbers(mi);
    p.lb = numbers(p.n);
    p.ub = numbers(p.n);
    set.problems.push_back(std::move(p));
  }
  if (!good) {
    return std::nullopt;
  }
  return set;
}

/// The file's problem with its slack variables dropped: price_i = H_ss / 2. Equalities come first,
/// so row me + i is row i of Ai. Variables beyond the file's are held at 0 by H = I.
/// False when it does not fit n variables and m rows.
template <int n, int m>
bool WithoutSlacks(const QpbProblem& from, QpProblem<n, m>& to) {
  const int kept = from.n - from.slacks();
  if (kept > n || from.equalities() + from.inequalities() > m) {
    return false;
  }
  to = {};
  for (int i = 0; i < kept; ++i) {
    for (int j = 0; j < kept; ++j) {
      to.H(i, j) = from.H[i * from.n + j];
    }
    to.g[i] = from.g[i];
    to.lb[i] = from.lb[i];
    to.ub[i] = from.ub[i];
  }
  const auto row = [&](const std::vector<double>& A, int i) {
    Vec<n> a = Vec<n>::Zero();
    for (int j = 0; j < kept; ++j) {
      a[j] = A[i * from.n + j];
    }
    return a;
  };
  bool fits = true;
  for (int i = 0; i < from.equalities(); ++i) {
    fits = to.AddRow(row(from.Ae, i), from.be[i], from.be[i]) && fits;
  }
  for (int i = 0; i < from.inequalities(); ++i) {
    double price = 0;
    for (int k = 0; k < from.slacks(); ++k) {
      if (from.soft_row[k] == i) {
        price = from.H[(kept + k) * from.n + kept + k] / 2;
      }
    }
    fits = to.AddRow(row(from.Ai, i), from.l[i], from.u[i], price) && fits;
  }
  return fits;
}

}  // namespace pipewright::test
