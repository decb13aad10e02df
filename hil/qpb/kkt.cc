// SPDX-License-Identifier: MIT
#include "hil/qpb/kkt.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pipewright::hil {
namespace {

/// A sum and the largest of its terms.
struct Sum {
  double value = 0;
  double largest = 0;

  void Add(double term) {
    value += term;
    largest = std::max(largest, std::fabs(term));
  }
};

Sum Product(const double* row, const std::vector<double>& x) {
  Sum y;
  for (std::size_t j = 0; j < x.size(); ++j) {
    y.Add(row[j] * x[j]);
  }
  return y;
}

class Residual {
 public:
  Residual(const QpbProblem& p, const QpbPoint& at) : p_(p), at_(at) {}

  double Worst() {
    SeeStationarity();
    for (int i = 0; i < p_.equalities(); ++i) {
      SeeRow(Product(&p_.Ae[i * p_.n], at_.x), p_.be[i], p_.be[i], at_.nu[i]);
    }
    for (int i = 0; i < p_.inequalities(); ++i) {
      SeeRow(Product(&p_.Ai[i * p_.n], at_.x), p_.l[i], p_.u[i], at_.lambda[i]);
    }
    for (int j = 0; j < p_.n; ++j) {
      SeeRow({at_.x[j], std::fabs(at_.x[j])}, p_.lb[j], p_.ub[j], at_.mu[j]);
    }
    return worst_;
  }

 private:
  void See(double residual) {
    worst_ =
        std::isnan(residual) ? std::numeric_limits<double>::infinity() : std::max(worst_, residual);
  }

  Sum Gradient(int j) const {
    Sum sum = Product(&p_.H[j * p_.n], at_.x);
    sum.Add(p_.g[j]);
    sum.Add(at_.mu[j]);
    for (int i = 0; i < p_.equalities(); ++i) {
      sum.Add(p_.Ae[i * p_.n + j] * at_.nu[i]);
    }
    for (int i = 0; i < p_.inequalities(); ++i) {
      sum.Add(p_.Ai[i * p_.n + j] * at_.lambda[i]);
    }
    return sum;
  }

  void SeeStationarity() {
    double off = 0;
    for (int j = 0; j < p_.n; ++j) {
      const Sum sum = Gradient(j);
      off = std::isnan(sum.value) ? sum.value : std::max(off, std::fabs(sum.value));
      scale_ = std::max(scale_, sum.largest);
    }
    See(off / scale_);
  }

  void SeeRow(const Sum& y, double lo, double hi, double lambda) {
    const double size = std::max(1.0, y.largest);
    See(std::max(y.value - hi, lo - y.value) / size);
    if (lambda != 0) {
      const double gap = std::fabs(lambda > 0 ? hi - y.value : y.value - lo);
      See(std::min(std::fabs(lambda) / scale_, gap / size));
    }
  }

  const QpbProblem& p_;
  const QpbPoint& at_;
  double scale_ = 1;
  double worst_ = 0;
};

}  // namespace

double KktResidual(const QpbProblem& p, const QpbPoint& at) { return Residual(p, at).Worst(); }

}  // namespace pipewright::hil
