// SPDX-License-Identifier: MIT
#include "platform/core/normal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace pipewright {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Point {
  double at;
  double value;
};

// mpmath at 60 digits, of the doubles printed here.
constexpr Point kCdf[] = {
    {-37.5, 4.6053530095819548438e-308},  {-30.0, 4.9067139271481870595e-198},
    {-20.125, 2.2288606383103429402e-90}, {-12.3, 4.5287069561587846514e-35},
    {-8.0, 6.2209605742717841235e-16},    {-6.0, 9.865876450376981407e-10},
    {-5.25, 7.6049605164887142511e-8},    {-4.0, 0.000031671241833119921254},
    {-3.1, 0.00096760321321835660196},    {-2.5, 0.006209665325776135167},
    {-2.0, 0.0227501319481792072},        {-1.5, 0.066807201268858066004},
    {-1.0, 0.15865525393145705141},       {-0.6744897501960817, 0.250000000000000012},
    {-0.5, 0.30853753872598689636},       {-0.25, 0.40129367431707627576},
    {-0.1, 0.46017216272297101633},       {-0.001, 0.49960105778608893741},
    {-1e-09, 0.4999999996010577196},      {0.0, 0.5},
    {1e-09, 0.5000000003989422804},       {0.001, 0.50039894221391106259},
    {0.1, 0.53982783727702898367},        {0.5, 0.69146246127401310364},
    {1.0, 0.84134474606854294859},        {1.6448536269514722, 0.94999999999999994607},
    {2.0, 0.9772498680518207928},         {2.5, 0.99379033467422386483},
    {3.0, 0.99865010196836990547},        {4.0, 0.99996832875816688008},
    {6.0, 0.99999999901341235496},        {8.0, 0.9999999999999993779},
};
constexpr Point kQuantile[] = {
    {1e-300, -37.047096299361199237},
    {1e-100, -21.273453560965324294},
    {1e-20, -9.2623400897984075796},
    {1e-10, -6.3613409024040561991},
    {1e-06, -4.7534243088228989573},
    {0.0001, -3.7190164854556805523},
    {0.001, -3.0902323061678135354},
    {0.01, -2.3263478740408410931},
    {0.025, -1.9599639845400542118},
    {0.05, -1.644853626951472688},
    {0.1, -1.2815515655446004353},
    {0.2, -0.84162123357291416552},
    {0.25, -0.6744897501960817432},
    {0.3, -0.52440051270804081597},
    {0.4, -0.25334710313579974132},
    {0.49, -0.025068908258711058033},
    {0.4999, -0.00025066283008800749239},
    {0.499999999, -2.5066283428845326712e-9},
    {0.500000001, 2.5066282037387114376e-9},
    {0.5001, 0.00025066283008800749239},
    {0.6, 0.25334710313579974132},
    {0.7, 0.52440051270804065631},
    {0.75, 0.6744897501960817432},
    {0.8, 0.8416212335729143638},
    {0.9, 1.2815515655446005935},
    {0.95, 1.6448536269514722843},
    {0.975, 1.9599639845400538556},
    {0.99, 2.3263478740408407676},
    {0.999, 3.0902323061678132778},
    {0.9999, 3.7190164854557083867},
    {0.999999, 4.7534243088170877657},
};

double RelativeError(double got, double want) {
  return want == 0 ? std::fabs(got) : std::fabs(got / want - 1);
}

TEST(NormalCdf, AgreesWithSixtyDigits) {
  for (const Point& p : kCdf) {
    SCOPED_TRACE(testing::Message() << "x = " << p.at);
    EXPECT_LE(RelativeError(NormalCdf(p.at), p.value), 1e-15);
  }
}

TEST(NormalCdf, EndsAtZeroAndOneAndPassesNanOn) {
  EXPECT_EQ(NormalCdf(-kInf), 0);
  EXPECT_EQ(NormalCdf(-50), 0);
  EXPECT_EQ(NormalCdf(kInf), 1);
  EXPECT_EQ(NormalCdf(50), 1);
  EXPECT_TRUE(std::isnan(NormalCdf(kNan)));
}

/// Phi by the host's erfc in extended precision, which no part of ours uses.
long double HostCdf(long double x) { return std::erfc(-x / std::sqrt(2.0L)) / 2; }

double RelativeError(double got, long double want) {
  return static_cast<double>(std::fabs((got - want) / want));
}

TEST(NormalCdf, AgreesWithTheErrorFunctionOfTheHostEverywhere) {
  static_assert(std::numeric_limits<long double>::digits >= 64);
  for (double x = -37.5; x <= 37.5; x += 0.00137) {
    ASSERT_LE(RelativeError(NormalCdf(x), HostCdf(x)), 1e-15) << "x = " << x;
  }
}

TEST(NormalPdf, IsTheDerivativeOfTheCdf) {
  for (double x = -6; x <= 6; x += 0.37) {
    const double h = 1e-5;
    EXPECT_NEAR((NormalCdf(x + h) - NormalCdf(x - h)) / (2 * h), NormalPdf(x), 1e-10);
  }
  EXPECT_EQ(NormalPdf(kInf), 0);
  EXPECT_TRUE(std::isnan(NormalPdf(kNan)));
}

TEST(NormalQuantile, AgreesWithSixtyDigits) {
  for (const Point& p : kQuantile) {
    SCOPED_TRACE(testing::Message() << "p = " << p.at);
    EXPECT_LE(RelativeError(NormalQuantile(p.at), p.value), 1e-15);
  }
}

/// The root of the host's Phi by Newton's method in extended precision, from ours.
long double HostQuantile(double p, long double start) {
  long double z = start;
  for (int round = 0; round < 4; ++round) {
    const long double pdf = std::exp(-z * z / 2) / std::sqrt(2 * 3.14159265358979323846L);
    const long double central = std::erf(z / std::sqrt(2.0L)) / 2 - (p - 0.5L);
    z -= (p > 0.25 && p < 0.75 ? central : HostCdf(z) - p) / pdf;
  }
  return z;
}

TEST(NormalQuantile, AgreesWithTheErrorFunctionOfTheHostEverywhere) {
  const auto expect = [](double p) {
    const double z = NormalQuantile(p);
    ASSERT_LE(RelativeError(z, HostQuantile(p, z)), 1e-15) << "p = " << p;
    ASSERT_EQ(NormalQuantile(1 - p), p == 1 - (1 - p) ? -z : NormalQuantile(1 - p));
  };
  for (double p = 0.0000917; p < 0.5; p += 0.0000917) {
    expect(p);
  }
  for (double exponent = -300; exponent < -4; exponent += 0.0171) {
    expect(std::pow(10, exponent));
  }
  for (double off = 1e-12; off < 1e-3; off *= 1.13) {
    expect(0.5 - off);
  }
}

TEST(NormalQuantile, InvertsTheCdf) {
  for (double x = -37; x <= 0; x += 0.0413) {
    EXPECT_LE(std::fabs(NormalQuantile(NormalCdf(x)) - x), 1e-14 * (1 + std::fabs(x))) << x;
  }
}

TEST(NormalQuantile, RefusesWhatIsNoProbability) {
  EXPECT_EQ(NormalQuantile(0), -kInf);
  EXPECT_EQ(NormalQuantile(1), kInf);
  EXPECT_EQ(NormalQuantile(0.5), 0);
  EXPECT_TRUE(std::isnan(NormalQuantile(-1e-300)));
  EXPECT_TRUE(std::isnan(NormalQuantile(1.0000001)));
  EXPECT_TRUE(std::isnan(NormalQuantile(kNan)));
}

}  // namespace
}  // namespace pipewright
