// SPDX-License-Identifier: MIT
#include "ctrl/envelope/envelope.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "platform/core/rng.h"

namespace pipewright {
namespace {

using std::chrono::milliseconds;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

EnvelopeConfig Config() {
  EnvelopeConfig c;
  c.u_max << 0.4, 1.0, Vec<kArmJoints>::Constant(1.0);
  c.a_max << 0.8, 2.0, Vec<kArmJoints>::Constant(10.0);
  c.q_min.setConstant(-2);
  c.q_max.setConstant(2);
  return c;
}

RobotState Healthy(Time stamp) {
  RobotState s;
  s.stamp = stamp;
  s.valid = true;
  return s;
}

Time At(int ms) { return Time{milliseconds(1000 + ms)}; }

Controls Slow() { return Controls::Constant(0.005); }

/// An envelope whose last command was u.
Envelope Moving(const Controls& u) {
  EnvelopeConfig c = Config();
  Envelope e(c);
  for (int i = 0; i < 200; ++i) {
    (void)e.Step(u, Healthy(At(0)), At(0));
  }
  return e;
}

TEST(EnvelopeConfig, IsCheckedFieldByField) {
  EXPECT_TRUE(Valid(Config()));
  EXPECT_FALSE(Valid(EnvelopeConfig{}));
  const auto broken = [](auto change) {
    EnvelopeConfig c = Config();
    change(c);
    return !Valid(c);
  };
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.period = Duration::zero(); }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.state_timeout = Duration::zero(); }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.u_max[3] = 0; }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.u_max[3] = kInf; }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.a_max[0] = -1; }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.a_max[0] = kNan; }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.q_min[6] = 3; }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.q_min[6] = -kInf; }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.q_max[6] = kInf; }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.braking_share = 0; }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.braking_share = 1.01; }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.braking_share = 5e-324; }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.a_max[8] = 1e300; }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.u_max[8] = 5e-324; }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.state_timeout = Duration::max(); }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.period = Duration::max(); }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.longest_gap = milliseconds(9); }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.longest_gap = Duration::max(); }));
  EXPECT_TRUE(broken([](EnvelopeConfig& c) { c.overruns_max = 0; }));
}

TEST(Envelope, LetsAModestWishPassUnchanged) {
  Envelope e(Config());
  const EnvelopeResult r = e.Step(Slow(), Healthy(At(0)), At(5));
  EXPECT_EQ(r.u, Slow());
  EXPECT_FALSE(r.changed);
  EXPECT_FALSE(r.stopping);
  EXPECT_EQ(e.counters().steps, 1u);
  EXPECT_EQ(e.counters().speed + e.counters().acceleration + e.counters().joint_position, 0u);
}

TEST(Envelope, StepsTowardsAFastWishAtTheAccelerationLimit) {
  Envelope e(Config());
  Controls wanted = Controls::Zero();
  wanted[0] = 0.4;
  wanted[4] = -1.0;
  const EnvelopeResult r = e.Step(wanted, Healthy(At(0)), At(0));
  EXPECT_DOUBLE_EQ(r.u[0], 0.008);
  EXPECT_DOUBLE_EQ(r.u[4], -0.1);
  EXPECT_TRUE(r.changed);
  EXPECT_EQ(e.counters().acceleration, 1u);
  EXPECT_EQ(e.counters().speed, 0u);
}

TEST(Envelope, ShrinksATooFastWishWithoutTurningIt) {
  Controls wanted = Controls::Zero();
  wanted << 0.8, 0.5, 0.1, 0.2, 0.3, -0.4, 0.5, -0.6, 0.7;
  Envelope e = Moving(wanted);
  const EnvelopeResult r = e.Step(wanted, Healthy(At(0)), At(0));
  EXPECT_LT((r.u - wanted / 2).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_GE(e.counters().speed, 1u);
}

TEST(Envelope, TakesEvenTheLargestNumberForAWish) {
  Envelope e(Config());
  const EnvelopeResult r =
      e.Step(Controls::Constant(std::numeric_limits<double>::max()), Healthy(At(0)), At(0));
  EXPECT_TRUE(r.u.allFinite());
  EXPECT_EQ(e.counters().speed, 1u);
}

struct StopCase {
  const char* name;
  void (*spoil)(Controls& wanted, RobotState& state);
  std::uint64_t EnvelopeCounters::*counter;
};

constexpr StopCase kStops[] = {
    {"a wish that is not a number", [](Controls& u, RobotState&) { u[8] = kNan; },
     &EnvelopeCounters::not_finite},
    {"an infinite wish", [](Controls& u, RobotState&) { u[0] = -kInf; },
     &EnvelopeCounters::not_finite},
    {"a state just too old", [](Controls&, RobotState& s) { s.stamp -= milliseconds(51); },
     &EnvelopeCounters::stale},
    {"a state of the future", [](Controls&, RobotState& s) { s.stamp += milliseconds(11); },
     &EnvelopeCounters::stale},
    {"a state that says it is not valid", [](Controls&, RobotState& s) { s.valid = false; },
     &EnvelopeCounters::invalid_state},
    {"a position that is not a number", [](Controls&, RobotState& s) { s.q[0] = kNan; },
     &EnvelopeCounters::invalid_state},
    {"a speed that is infinite", [](Controls&, RobotState& s) { s.u[2] = kInf; },
     &EnvelopeCounters::invalid_state},
    {"the emergency stop", [](Controls&, RobotState& s) { s.emergency_stop = true; },
     &EnvelopeCounters::emergency_stop},
};

TEST(Envelope, RampsToZeroAsFastAsAllowedForEachReason) {
  for (const StopCase& c : kStops) {
    SCOPED_TRACE(c.name);
    Controls u = Controls::Zero();
    u << -0.4, 0.5, 1, -1, 1, -1, 0.05, -0.05, 0;
    Envelope e = Moving(u);
    Controls wanted = u;
    RobotState state = Healthy(At(0));
    c.spoil(wanted, state);
    EnvelopeResult r = e.Step(wanted, state, At(0));
    EXPECT_TRUE(r.stopping);
    EXPECT_TRUE(r.changed);
    Controls expected = Controls::Zero();
    expected << -0.392, 0.48, 0.9, -0.9, 0.9, -0.9, 0, 0, 0;
    EXPECT_LT((r.u - expected).cwiseAbs().maxCoeff(), 1e-12);
    for (int i = 0; i < 60; ++i) {
      r = e.Step(wanted, state, At(0));
    }
    EXPECT_EQ(r.u, Controls::Zero().eval());
    EXPECT_EQ(e.counters().*c.counter, 61u);
    const EnvelopeCounters& n = e.counters();
    EXPECT_EQ(n.not_finite + n.stale + n.invalid_state + n.emergency_stop, 61u);
  }
}

TEST(Envelope, StopsInTheSameTimeHoweverLateItsCyclesAre) {
  // 0.4 m/s at 0.8 m/s^2 and 1 rad/s at 10 rad/s^2, from the step before the fault.
  Controls u = Controls::Zero();
  u << 0.4, -1, 1, -1, 0, 0, 0, 0, 0;
  for (int periods = 1; periods <= 11; ++periods) {
    SCOPED_TRACE(periods);
    Envelope e = Moving(u);
    RobotState unsound = Healthy(At(0));
    unsound.valid = false;
    for (int ms = 10 * periods; ms <= 500 + 10 * periods; ms += 10 * periods) {
      const Controls sent = e.Step(u, unsound, At(ms)).u;
      EXPECT_NEAR(sent[0], std::max(0.0, 0.4 - 0.8 * 1e-3 * ms), 1e-9) << ms;
      EXPECT_NEAR(sent[1], std::min(0.0, -1 + 2 * 1e-3 * ms), 1e-9) << ms;
      EXPECT_NEAR(sent[2], std::max(0.0, 1 - 10 * 1e-3 * ms), 1e-9) << ms;
    }
  }
}

TEST(Envelope, MakesUpForNoMoreThanTheLongestGap) {
  Controls u = Controls::Zero();
  u[0] = 0.4;
  Envelope e = Moving(u);
  RobotState unsound = Healthy(At(0));
  unsound.valid = false;
  EXPECT_NEAR(e.Step(u, unsound, At(5000)).u[0], 0.4 - 0.8 * 0.2, 1e-12);
  // Nor does a clock that stands still, or goes backwards, stop the ramp.
  EXPECT_NEAR(e.Step(u, unsound, At(5000)).u[0], 0.4 - 0.8 * 0.21, 1e-12);
  EXPECT_NEAR(e.Step(u, unsound, At(0)).u[0], 0.4 - 0.8 * 0.22, 1e-12);
}

TEST(Envelope, ALateCycleDoesNotLetItAccelerateMore) {
  Envelope e(Config());
  Controls wanted = Controls::Zero();
  wanted[0] = 0.4;
  (void)e.Step(wanted, Healthy(At(0)), At(0));
  EXPECT_NEAR(e.Step(wanted, Healthy(At(40)), At(40)).u[0], 2 * 0.008, 1e-12);
}

TEST(Envelope, CountsLateCyclesAndStopsAtTheFifthInARow) {
  Envelope e = Moving(Slow());
  int ms = 0;
  const auto step = [&](int later_ms) {
    ms += later_ms;
    return e.Step(Slow(), Healthy(At(ms)), At(ms)).stopping;
  };
  for (int row = 0; row < 3; ++row) {
    for (int i = 0; i < 4; ++i) {
      EXPECT_FALSE(step(15));
    }
    EXPECT_FALSE(step(14));  // in time: those before do not count
  }
  EXPECT_EQ(e.counters().overruns, 12U);
  for (int i = 1; i <= 7; ++i) {
    EXPECT_EQ(step(20), i >= 5);
  }
  EXPECT_EQ(e.counters().overrun_stop, 3U);
  EXPECT_FALSE(step(10));
}

TEST(Envelope, AcceptsAStateUpToItsTimeout) {
  Envelope e(Config());
  EXPECT_FALSE(e.Step(Slow(), Healthy(At(0)), At(50)).stopping);
  EXPECT_FALSE(e.Step(Slow(), Healthy(At(10)), At(0)).stopping);
}

TEST(Envelope, GoesOnByItselfOnceAStaleStateIsFresh) {
  Envelope e(Config());
  EXPECT_TRUE(e.Step(Slow(), Healthy(At(0)), At(100)).stopping);
  EXPECT_FALSE(e.Step(Slow(), Healthy(At(110)), At(110)).stopping);
}

TEST(Envelope, LatchesTheEmergencyStopUntilRearmed) {
  Envelope e(Config());
  RobotState pressed = Healthy(At(0));
  pressed.emergency_stop = true;
  (void)e.Step(Slow(), pressed, At(0));
  EXPECT_TRUE(e.latched());
  EXPECT_EQ(e.Rearm(), Status::kFault);
  EXPECT_TRUE(e.latched());
  EXPECT_TRUE(e.Step(Slow(), Healthy(At(10)), At(10)).stopping);
  EXPECT_EQ(e.Rearm(), Status::kOk);
  EXPECT_FALSE(e.latched());
  EXPECT_FALSE(e.Step(Slow(), Healthy(At(20)), At(20)).stopping);
}

TEST(Envelope, LetsAJointBeyondItsLimitOnlyBack) {
  for (const double side : {1.0, -1.0}) {
    Envelope e(Config());
    RobotState s = Healthy(At(0));
    s.q[5] = side * 2.1;
    Controls wanted = Controls::Zero();
    wanted[4] = side * 0.05;
    EXPECT_EQ(e.Step(wanted, s, At(0)).u[4], 0);
    EXPECT_EQ(e.counters().joint_position, 1u);
    EXPECT_EQ(e.Step(-wanted, s, At(0)).u[4], -wanted[4]);
  }
}

/// Joints that follow the command `delay` periods late, measured `age` periods ago.
void DriveAtLimits(int delay, int age, std::uint64_t seed) {
  constexpr int kHistory = 8;
  Rng rng(seed);
  Envelope e(Config());
  Controls sent[kHistory];
  ArmVector past[kHistory];
  for (int k = 0; k < kHistory; ++k) {
    sent[k].setZero();
    past[k].setZero();
  }
  Controls wanted = Controls::Zero();
  Controls before = Controls::Zero();
  for (int step = 0; step < 4000; ++step) {
    if (step % 150 == 0) {
      for (int i = 0; i < kControls; ++i) {
        wanted[i] = rng.Uniform(-3, 3);
      }
    }
    RobotState s = Healthy(Time{milliseconds(10 * (step - age))});
    s.q.tail<kArmJoints>() = past[age];
    s.u = sent[std::min(age + delay, kHistory - 1)];
    const Controls u = e.Step(wanted, s, Time{milliseconds(10 * step)}).u;
    ASSERT_LE((u.cwiseAbs() - Config().u_max).maxCoeff(), 0);
    if (age == 1) {  // a constant age leaves the braking curve within the acceleration limit
      ASSERT_LE(((u - before).cwiseAbs() - Config().a_max * 0.01).maxCoeff(), 1e-9);
    }
    before = u;
    for (int k = kHistory - 1; k > 0; --k) {
      sent[k] = sent[k - 1];
      past[k] = past[k - 1];
    }
    sent[0] = u;
    past[0] = past[1] + 0.01 * sent[delay].tail<kArmJoints>();
    ASSERT_LE(past[0].cwiseAbs().maxCoeff(), 2) << "delay " << delay << ", age " << age;
  }
}

TEST(Envelope, NeverDrivesAJointPastItsLimit) {
  for (int delay = 0; delay <= 1; ++delay) {
    for (int age = 0; age <= 4; ++age) {
      DriveAtLimits(delay, age, static_cast<std::uint64_t>(10 * delay + age));
    }
  }
}

TEST(Envelope, SendsNothingUnlawfulWhateverComesIn) {
  Rng rng(99);
  const double odd[] = {0, -0.0, kNan, kInf, -kInf, 1e308, -1e308, 5e-324, 1, -1, 0.3, -0.02};
  const auto any = [&] { return rng.Uniform() < 0.7 ? rng.Uniform(-3, 3) : odd[rng.Index(12)]; };
  const EnvelopeConfig c = Config();
  Envelope e(c);
  Controls before = Controls::Zero();
  for (int step = 0; step < 20000; ++step) {
    Controls wanted;
    RobotState s;
    const bool calm = rng.Uniform() < 0.8;
    for (int i = 0; i < kControls; ++i) {
      wanted[i] = calm ? rng.Uniform(-3, 3) : any();
      s.u[i] = calm ? rng.Uniform(-1, 1) : any();
    }
    for (int i = 0; i < kDof; ++i) {
      s.q[i] = calm ? rng.Uniform(-2.2, 2.2) : any();
    }
    s.valid = rng.Uniform() < 0.95;
    s.emergency_stop = rng.Uniform() < 0.01;
    s.stamp = Time{milliseconds(rng.Index(80))};
    const EnvelopeResult r = e.Step(wanted, s, Time{milliseconds(70)});
    ASSERT_TRUE(r.u.allFinite());
    for (int i = 0; i < kControls; ++i) {
      ASSERT_LE(std::fabs(r.u[i]), c.u_max[i]);
      // A joint limit may brake harder than a_max, towards zero, never further.
      const double step_max = c.a_max[i] * 0.01 + 1e-12;
      if (std::fabs(r.u[i] - before[i]) > step_max) {
        ASSERT_GE(i, 2);
        ASSERT_LE(std::fabs(r.u[i]), std::fabs(before[i]));
        ASSERT_GE(r.u[i] * before[i], 0);
      }
      ASSERT_TRUE(!r.stopping || std::fabs(r.u[i]) <= std::fabs(before[i]));
    }
    before = r.u;
    if (rng.Uniform() < 0.05) {
      (void)e.Rearm();
    }
  }
  EXPECT_EQ(e.counters().steps, 20000u);
}

}  // namespace
}  // namespace pipewright
