// SPDX-License-Identifier: MIT
#include "platform/core/normal.h"

#include <cmath>
#include <iterator>
#include <limits>

namespace pipewright {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kSqrt2Pi = 2.5066282746310005024;

/// Chebyshev coefficients of F(t) = (x + 3/2) R(x), t = (x - 4)/(x + 4), where R = (1 - Phi)/phi is
/// Mills' ratio: all of x >= 0 on t in [-1, 1], truncated below 2e-18. By mpmath at 40 digits.
constexpr double kMills[] = {
    1.3779705173260460991,      -0.44822540969113506713,    0.069490423328186129268,
    0.0061261062196264537198,   -0.0071925746113331786468,  0.0021207406133922636619,
    -0.00029143612415676560368, -6.4084345122311462619e-6,  8.9041725761913604971e-6,
    -6.6463696149889930549e-7,  -2.3841303511759760913e-7,  3.4280800763334032883e-8,
    7.6031800732636017811e-9,   -1.3877846241322547527e-9,  -3.0917652383673248999e-10,
    5.1534047322902578433e-11,  1.5094164602890812051e-11,  -1.6090454956015511805e-12,
    -7.9509656017722215319e-13, 2.1422982830295601007e-14,  4.1027537905385803777e-14,
    2.6502414857736446958e-15,  -1.8759042515233550027e-15, -3.4877610457778745407e-16,
    6.1456380963900449703e-17,  2.7439414637955380725e-17,
};

/// e^y for y <= 0, by y = k ln 2 + r, |r| <= ln 2 / 2, and the Taylor series of r. About 1 ulp.
double Exp(double y) {
  constexpr double kLn2Hi = 0x1.62e42fefa38p-1;  // 43 bits: k kLn2Hi is exact
  constexpr double kLn2Lo = 0x1.ef35793c7673p-45;
  if (y < -800) {
    return 0;
  }
  const double k = std::floor(y * 1.4426950408889634 + 0.5);
  const double r = (y - k * kLn2Hi) - k * kLn2Lo;
  double tail = 1.0 / 14;
  for (int i = 13; i >= 2; --i) {
    tail = (1 + r * tail) / i;
  }
  return std::ldexp(1 + (r + r * r * tail), static_cast<int>(k));
}

/// e^(-x^2/2), with x = h + (x - h), h = x to 1/16, so that no digit of the square is lost.
double ExpHalfSquare(double x) {
  const double h = std::trunc(x * 16) / 16;
  return Exp(-h * h / 2) * Exp(-(x - h) * (x + h) / 2);
}

/// (1 - Phi(x)) / phi(x) for x >= 0.
double MillsRatio(double x) {
  const double t = (x - 4) / (x + 4);
  double b1 = 0;
  double b2 = 0;
  for (int i = static_cast<int>(std::size(kMills)) - 1; i > 0; --i) {  // Clenshaw
    const double b = kMills[i] + (2 * t * b1 - b2);
    b2 = b1;
    b1 = b;
  }
  return (kMills[0] + (t * b1 - b2)) / (x + 1.5);
}

/// Phi(z) - 1/2 = phi(z) (z + z^3/3 + z^5/15 + ...) for |z| < 1.
double CentralPart(double z) {
  const double z2 = z * z;
  double sum = 0;
  for (int k = 45; k >= 3; k -= 2) {
    sum = z2 / k * (1 + sum);
  }
  return NormalPdf(z) * (z + z * sum);
}

/// ln p to 1e-4, for 0 < p < 1. Not the library's: its last bit differs between machines.
double RoughLog(double p) {
  int exponent = 0;
  const double f = std::frexp(p, &exponent);
  const double s = (f - 0.7071067811865476) / (f + 0.7071067811865476);  // |s| <= 0.172
  return (exponent - 0.5) * 0.6931471805599453 + 2 * s * (1 + s * s / 3);
}

/// A start for Newton's method within 5e-4, 0 < p <= 1/2 (Abramowitz, Stegun 26.2.23).
double CrudeQuantile(double p) {
  const double t = std::sqrt(-2 * RoughLog(p));
  return (2.515517 + t * (0.802853 + t * 0.010328)) /
             (1 + t * (1.432788 + t * (0.189269 + t * 0.001308))) -
         t;
}

/// Halley's correction of z for a miss of `excess` in probability.
double Corrected(double z, double excess) {
  const double step = excess / NormalPdf(z);
  return z - step / (1 + z * step / 2);
}

/// Of 0 < p ≤ 1/2.
double LowerQuantile(double p) {
  double z = CrudeQuantile(p);
  for (int round = 0; round < 3; ++round) {  // cubic: 5e-4, 1e-10, rounding
    z = Corrected(z, p > 0.25 ? CentralPart(z) - (p - 0.5) : NormalCdf(z) - p);
  }
  return z;
}

}  // namespace

double NormalPdf(double x) {
  if (std::isnan(x)) {
    return x;
  }
  return std::fabs(x) > 40 ? 0 : ExpHalfSquare(x) / kSqrt2Pi;
}

double NormalCdf(double x) {
  if (std::isnan(x)) {
    return x;
  }
  if (x < -40) {
    return 0;
  }
  if (x > 40) {
    return 1;
  }
  const double tail = NormalPdf(x) * MillsRatio(std::fabs(x));
  return x < 0 ? tail : 1 - tail;
}

double NormalQuantile(double p) {
  if (!(p >= 0 && p <= 1)) {
    return kNan;
  }
  if (p == 0 || p == 1) {
    return p == 0 ? -kInf : kInf;
  }
  return p > 0.5 ? -LowerQuantile(1 - p) : LowerQuantile(p);  // 1 - p is exact
}

}  // namespace pipewright
