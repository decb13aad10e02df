// SPDX-License-Identifier: MIT
#include "ctrl/daemon/service_machine.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

/// A machine whose robot does at once what it is told.
class Machine {
 public:
  explicit Machine(bool autostart = false, std::string_view latched = "")
      : machine(autostart, latched) {}

  void Step() {
    now += 4ms;
    const ServiceOutput out = machine.Step(input, now);
    input.asked_to_end = false;
    starts += out.start ? 1 : 0;
    stops += out.request_stop ? 1 : 0;
    quits += out.quit ? 1 : 0;
    joins += out.join ? 1 : 0;
    if (out.start) {
      machine.Started(start_error);
      input.phase = ControlPhase::kRunning;
      input.threads_returned = false;
      input.mission_ended = false;
    }
    if (out.request_stop && obeys) {
      input.phase = ControlPhase::kStopped;
    }
    if (out.quit) {
      input.threads_returned = returns;
    }
  }
  void Steps(int count) {
    for (int i = 0; i < count; ++i) {
      Step();
    }
  }
  void Run() {
    input.bus_ok = true;
    Step();
    ASSERT_EQ(machine.Command(ServiceCommand::kStart), nullptr);
    Step();
    ASSERT_EQ(machine.state(), ServiceState::kRunning);
  }
  ServiceState state() const { return machine.state(); }
  std::string reason() const { return std::string(machine.reason()); }

  ServiceMachine machine;
  ServiceInput input;
  Time now{};
  std::string start_error;
  bool obeys = true;
  bool returns = true;
  int starts = 0;
  int stops = 0;
  int quits = 0;
  int joins = 0;
};

TEST(ServiceMachine, StartsNothingWithoutABusOrAWord) {
  Machine m;
  m.Step();
  EXPECT_EQ(m.state(), ServiceState::kNoBus);
  EXPECT_NE(m.machine.Command(ServiceCommand::kStart), nullptr);
  m.input.bus_ok = true;
  m.Steps(3);
  EXPECT_EQ(m.state(), ServiceState::kIdle);
  EXPECT_EQ(m.starts, 0);
  m.input.bus_ok = false;
  m.Step();
  EXPECT_EQ(m.state(), ServiceState::kNoBus);
}

TEST(ServiceMachine, ABusThatGoesTakesAnUnansweredStartWithIt) {
  Machine m;
  m.input.bus_ok = true;
  m.Step();
  EXPECT_EQ(m.machine.Command(ServiceCommand::kStart), nullptr);
  m.input.bus_ok = false;
  m.Step();
  m.input.bus_ok = true;
  m.Steps(3);
  EXPECT_EQ(m.starts, 0);
}

TEST(ServiceMachine, EveryWayOutOfARunGoesThroughRestAndLatches) {
  const struct {
    const char* name;
    std::function<void(Machine&)> end;
    ServiceState state;
    const char* reason;
  } cases[] = {
      {"the mission ends",
       [](Machine& m) {
         m.input.mission_ended = true;
         m.input.why = "complete";
       },
       ServiceState::kEnded, "complete"},
      {"stop", [](Machine& m) { EXPECT_EQ(m.machine.Command(ServiceCommand::kStop), nullptr); },
       ServiceState::kEnded, "stopped by an operator"},
      {"estop",
       [](Machine& m) { EXPECT_EQ(m.machine.Command(ServiceCommand::kEmergencyStop), nullptr); },
       ServiceState::kEmergencyStop, "emergency stop by an operator"},
      {"a task hangs", [](Machine& m) { m.input.silent_task = "mapping"; }, ServiceState::kEnded,
       "mapping does not answer"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    Machine m;
    m.Run();
    c.end(m);
    m.Step();
    EXPECT_EQ(m.state(), ServiceState::kStopping);
    EXPECT_NE(m.machine.Command(ServiceCommand::kStart), nullptr);
    EXPECT_NE(m.machine.Command(ServiceCommand::kRearm), nullptr);
    m.Steps(5);
    EXPECT_EQ(m.state(), c.state);
    EXPECT_EQ(m.reason(), c.reason);
    EXPECT_TRUE(m.machine.latched());
    EXPECT_EQ(m.stops, 1);
    EXPECT_EQ(m.quits, 1);
    EXPECT_EQ(m.joins, 1);
    EXPECT_NE(m.machine.Command(ServiceCommand::kStart), nullptr);
    m.input.silent_task = nullptr;
    EXPECT_EQ(m.machine.Command(ServiceCommand::kRearm), nullptr);
    m.Steps(3);
    EXPECT_EQ(m.state(), ServiceState::kIdle);
    EXPECT_EQ(m.reason(), "");
    EXPECT_EQ(m.machine.Command(ServiceCommand::kStart), nullptr);
    m.Step();
    EXPECT_EQ(m.state(), ServiceState::kRunning);
    EXPECT_EQ(m.starts, 2);
  }
}

TEST(ServiceMachine, AnEmergencyStopLatchesFromEveryState) {
  Machine no_bus;
  Machine idle;
  idle.input.bus_ok = true;
  Machine ended;
  ended.Run();
  EXPECT_EQ(ended.machine.Command(ServiceCommand::kStop), nullptr);
  ended.Steps(5);
  for (Machine* m : {&no_bus, &idle, &ended}) {
    m->Step();
    EXPECT_EQ(m->machine.Command(ServiceCommand::kEmergencyStop), nullptr);
    EXPECT_NE(m->machine.Command(ServiceCommand::kRearm), nullptr);  // not before it is taken
    m->Step();
    EXPECT_EQ(m->state(), ServiceState::kEmergencyStop);
    EXPECT_NE(m->machine.Command(ServiceCommand::kStart), nullptr);
  }
}

TEST(ServiceMachine, AnEmergencyStopWhileStoppingStillLatches) {
  Machine m;
  m.obeys = false;
  m.Run();
  EXPECT_EQ(m.machine.Command(ServiceCommand::kStop), nullptr);
  m.Steps(2);
  EXPECT_EQ(m.machine.Command(ServiceCommand::kEmergencyStop), nullptr);
  m.Step();
  m.input.phase = ControlPhase::kStopped;
  m.Steps(3);
  EXPECT_EQ(m.state(), ServiceState::kEmergencyStop);
  EXPECT_EQ(m.reason(), "emergency stop by an operator");
}

TEST(ServiceMachine, AskedToEndItGoesOnlyAfterRest) {
  Machine m;
  m.obeys = false;
  m.Run();
  m.input.asked_to_end = true;
  m.Steps(100);
  EXPECT_EQ(m.state(), ServiceState::kStopping);
  EXPECT_EQ(m.quits, 0);
  m.input.phase = ControlPhase::kStopped;
  m.Steps(3);
  EXPECT_EQ(m.state(), ServiceState::kGone);
  EXPECT_EQ(m.joins, 1);
}

TEST(ServiceMachine, WaitsForRestAtMostItsPatience) {
  for (const auto& [phase, patience] :
       {std::pair{ControlPhase::kStopping, ServiceMachine::kStopPatience},
        std::pair{ControlPhase::kFault, ServiceMachine::kFaultPatience}}) {
    Machine m;
    m.obeys = false;
    m.Run();
    m.input.phase = phase;
    EXPECT_EQ(m.machine.Command(ServiceCommand::kStop), nullptr);
    m.Step();
    const Time since = m.now;
    while (m.quits == 0 && m.now - since < 60s) {
      m.Step();
    }
    EXPECT_GT(m.now - since, patience);
    EXPECT_LT(m.now - since, patience + 10ms);
    m.Steps(2);
    EXPECT_EQ(m.state(), ServiceState::kEnded);
    EXPECT_EQ(m.reason(), phase == ControlPhase::kFault
                              ? "stopped by an operator"
                              : "stopped by an operator; it was not seen to come to rest");
  }
}

TEST(ServiceMachine, ThreadsThatDoNotReturnAreNotJoined) {
  Machine m;
  m.returns = false;
  m.Run();
  m.input.asked_to_end = true;
  m.Steps(1000);
  EXPECT_EQ(m.joins, 0);
  EXPECT_EQ(m.state(), ServiceState::kStopping);
  EXPECT_FALSE(m.machine.stuck(m.now));
  EXPECT_TRUE(m.machine.stuck(m.now + ServiceMachine::kReturnPatience));
  m.input.threads_returned = true;
  m.Steps(2);
  EXPECT_EQ(m.state(), ServiceState::kGone);
}

TEST(ServiceMachine, StartsByItselfOnceAndNotWhenLatched) {
  Machine m(true);
  m.input.bus_ok = true;
  m.Steps(2);
  EXPECT_EQ(m.state(), ServiceState::kRunning);
  EXPECT_EQ(m.machine.Command(ServiceCommand::kStop), nullptr);
  m.Steps(5);
  EXPECT_EQ(m.machine.Command(ServiceCommand::kRearm), nullptr);
  m.Steps(5);
  EXPECT_EQ(m.state(), ServiceState::kIdle);
  EXPECT_EQ(m.starts, 1);

  Machine latched(true, "emergency stop by an operator");
  latched.input.bus_ok = true;
  latched.Steps(5);
  EXPECT_EQ(latched.state(), ServiceState::kEmergencyStop);
  EXPECT_EQ(latched.reason(), "emergency stop by an operator");
  EXPECT_EQ(latched.machine.Command(ServiceCommand::kRearm), nullptr);
  latched.Steps(5);
  EXPECT_EQ(latched.state(), ServiceState::kIdle);
  EXPECT_EQ(latched.starts, 0);
}

TEST(ServiceMachine, ARobotThatCannotBeStartedIsARunThatEnded) {
  Machine m;
  m.start_error = "the system gives no threads";
  m.input.bus_ok = true;
  m.Step();
  EXPECT_EQ(m.machine.Command(ServiceCommand::kStart), nullptr);
  m.Step();
  EXPECT_EQ(m.state(), ServiceState::kEnded);
  EXPECT_EQ(m.reason(), "the system gives no threads");
}

TEST(ServiceMachine, AStopBeforeTheStartTakesItBack) {
  Machine m;
  m.input.bus_ok = true;
  m.Step();
  EXPECT_NE(m.machine.Command(ServiceCommand::kStop), nullptr);
  EXPECT_EQ(m.machine.Command(ServiceCommand::kStart), nullptr);
  EXPECT_EQ(m.machine.Command(ServiceCommand::kStop), nullptr);
  m.Steps(3);
  EXPECT_EQ(m.starts, 0);
}

TEST(ServiceMachine, AReasonOfAnyLengthIsCut) {
  Machine m;
  m.Run();
  m.input.mission_ended = true;
  const std::string why(1000, 'x');
  m.input.why = why;
  m.Steps(5);
  EXPECT_EQ(m.state(), ServiceState::kEnded);
  EXPECT_EQ(m.reason(), why.substr(0, 200));
}

}  // namespace
}  // namespace pipewright
