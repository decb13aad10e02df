// SPDX-License-Identifier: MIT
#include "hil/devices/cia402_node.h"

#include <cmath>
#include <fstream>
#include <string>

#include "node_bench.h"

namespace pipewright::hil {
namespace {

using std::chrono::milliseconds;

std::int64_t Little(const can::Frame& frame, std::size_t from, int bytes) {
  std::int64_t value = 0;
  for (int i = bytes - 1; i >= 0; --i) {
    value = value * 256 + frame.data[from + static_cast<std::size_t>(i)];
  }
  const std::int64_t span = std::int64_t{1} << (8 * bytes);
  return value >= span / 2 ? value - span : value;
}

TEST(Cia402Node, BootsThenBeatsEvery100Ms) {
  NodeBench bench;
  bench.Run(400);
  const std::vector<can::Frame> beats = bench.Said(0x701);
  ASSERT_EQ(beats.size(), 4U);
  EXPECT_EQ(beats[0], Bytes(0x701, {0x00}));
  EXPECT_EQ(beats[0].stamp, Time(milliseconds(51)));
  EXPECT_EQ(beats[1], Bytes(0x701, {0x7F}));
  EXPECT_EQ(beats[2].stamp - beats[1].stamp, milliseconds(100));
  EXPECT_EQ(bench.said.size(), beats.size()) << "in pre-operational it says nothing else";
}

TEST(Cia402Node, ObeysTheNmtMasterAndOnlyWhenAddressed) {
  NodeBench bench(Cia402Config{.node_id = 3});
  bench.Run(60);
  bench.Hear(Bytes(0x000, {0x01, 0x02}));
  bench.Tick();
  EXPECT_EQ(bench.node.nmt(), NmtState::kPreOperational);
  bench.Hear(Bytes(0x000, {0x01, 0x00}));
  bench.Tick();
  EXPECT_EQ(bench.node.nmt(), NmtState::kOperational);
  bench.Hear(Bytes(0x000, {0x02, 0x03}));
  bench.Tick();
  EXPECT_EQ(bench.node.nmt(), NmtState::kStopped);
  bench.Hear(Bytes(0x000, {0x80, 0x03}));
  bench.Tick();
  EXPECT_EQ(bench.node.nmt(), NmtState::kPreOperational);
  bench.Hear(Bytes(0x000, {0x81, 0x03}));
  bench.Run(60);
  EXPECT_EQ(bench.Said(0x703).size(), 2U) << "a second boot-up";
  bench.Hear(Bytes(0x000, {0x55, 0x03}));
  bench.Hear(Bytes(0x000, {0x01}));
  bench.Tick();
  EXPECT_EQ(bench.node.rejected(), 2);
}

TEST(Cia402Node, ResetOfCommunicationKeepsTheDrivesSettings) {
  NodeBench bench;
  bench.Run(60);
  ASSERT_TRUE(bench.Write(0x6085, 0, 4, 5000000));
  ASSERT_TRUE(bench.Write(0x1017, 0, 2, 20));
  bench.Hear(Bytes(0x000, {0x82, 0x01}));
  bench.Run(60);
  EXPECT_EQ(bench.node.dictionary().Value(0x6085, 0), 5000000U);
  EXPECT_EQ(bench.node.dictionary().Value(0x1017, 0), 100U);
  bench.Hear(Bytes(0x000, {0x81, 0x01}));
  bench.Run(60);
  EXPECT_EQ(bench.node.dictionary().Value(0x6085, 0), 10000000U);
}

TEST(Cia402Node, ACommandTakesEffectAtSyncAndFeedbackIsSampledThere) {
  NodeBench bench;
  bench.Enable();
  bench.position_rad = 0.25;
  bench.Hear(Bytes(0x201, {0x0F, 0x00, 0x20, 0xA1, 0x07, 0x00}));  // 500000 = 0.5 rad/s
  bench.Run(10);
  EXPECT_EQ(bench.node.velocity_radps(), 0) << "no SYNC yet";
  bench.Hear(Bytes(0x080, {}));
  bench.Run(50);
  EXPECT_EQ(bench.node.velocity_radps(), 0.5);
  const can::Frame feedback = bench.Said(0x181).back();
  EXPECT_EQ(feedback.dlc, 8);
  EXPECT_EQ(Little(feedback, 0, 4), 250000);
  EXPECT_EQ(Little(feedback, 4, 4), 0);
  const double at_sync = bench.position_rad;
  bench.Cycle(0x0F, 500000);
  EXPECT_NEAR(static_cast<double>(Little(bench.Said(0x181).back(), 0, 4)) * 1e-6, at_sync, 1e-6);
  EXPECT_EQ(Little(bench.Said(0x181).back(), 4, 4), 500000);
}

TEST(Cia402Node, EachSyncGivesOneFeedbackFrame) {
  NodeBench bench;
  bench.Enable();
  const std::size_t before = bench.Said(0x181).size();
  for (int i = 0; i < 25; ++i) {
    bench.Cycle(0x0F, 0);
  }
  EXPECT_EQ(bench.Said(0x181).size() - before, 25U);
}

TEST(Cia402Node, StatusIsSentOnChangeAtMostEvery10MsAndAtLeastEvery250Ms) {
  NodeBench bench;
  bench.Enable();
  bench.Run(20);
  const std::size_t before = bench.Said(0x281).size();
  EXPECT_EQ(bench.Said(0x281).back(), Bytes(0x281, {0x37, 0x12, 0x09}));
  for (int i = 0; i < 100; ++i) {
    bench.Cycle(0x0F, 0);
  }
  EXPECT_EQ(bench.Said(0x281).size() - before, 4U);
  for (int i = 0; i < 20; ++i) {  // a change every ms
    bench.Hear(Bytes(0x201, {i % 2 == 0 ? 0x07 : 0x0F, 0, 0, 0, 0, 0}));
    bench.Hear(Bytes(0x080, {}));
    bench.Tick();
  }
  const std::vector<can::Frame> status = bench.Said(0x281);
  for (std::size_t i = 1; i < status.size(); ++i) {
    EXPECT_GE(status[i].stamp - status[i - 1].stamp, milliseconds(10));
  }
}

TEST(Cia402Node, ALostHostHeartbeatIsAFaultWithEmergency8130) {
  NodeBench bench;
  bench.Enable();
  ASSERT_TRUE(bench.Write(0x1400, 5, 2, 0));
  ASSERT_TRUE(bench.Write(0x1016, 1, 4, 0x7F << 16 | 300));
  bench.Hear(Bytes(0x77F, {0x05}));
  bench.Cycle(0x0F, 1000000);
  bench.Run(285);
  EXPECT_EQ(bench.node.drive_state(), DriveState::kOperationEnabled);
  bench.Run(10);
  ASSERT_EQ(bench.Said(0x081).size(), 1U);
  EXPECT_EQ(bench.Said(0x081)[0], Bytes(0x081, {0x30, 0x81, 0x11, 0, 0, 0, 0, 0}));
  EXPECT_EQ(bench.node.drive_state(), DriveState::kFaultReaction);
  bench.Run(150);  // 1 rad/s at 10 rad/s^2
  EXPECT_EQ(bench.node.drive_state(), DriveState::kFault);
  EXPECT_EQ(bench.node.velocity_radps(), 0);

  bench.Cycle(0x80, 0);
  EXPECT_EQ(bench.node.drive_state(), DriveState::kFault) << "the host is still silent";
  bench.Hear(Bytes(0x77F, {0x05}));
  bench.Cycle(0x00, 0);
  bench.Cycle(0x80, 0);
  EXPECT_EQ(bench.node.drive_state(), DriveState::kSwitchOnDisabled);
  EXPECT_EQ(bench.Said(0x081).back(), Bytes(0x081, {0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(Cia402Node, ALostCommandPduIsAFaultWithEmergency8250) {
  struct Case {
    const char* name;
    bool pdo, sync;
  };
  for (const Case& c : {Case{"no RPDO", false, true}, Case{"no SYNC", true, false}}) {
    SCOPED_TRACE(c.name);
    NodeBench bench;
    bench.Enable();
    bench.Cycle(0x0F, 1000000);
    for (int i = 0; i < 30; ++i) {
      if (c.pdo) {
        bench.Hear(Bytes(0x201, {0x0F, 0, 0x40, 0x42, 0x0F, 0}));
      }
      if (c.sync) {
        bench.Hear(Bytes(0x080, {}));
      }
      bench.Run(10);
    }
    EXPECT_EQ(bench.Said(0x081)[0], Bytes(0x081, {0x50, 0x82, 0x11, 0, 0, 0, 0, 0}));
    EXPECT_EQ(bench.node.drive_state(), DriveState::kFault);
    EXPECT_EQ(bench.node.velocity_radps(), 0);
  }
}

/// A node enabled by SDO alone, told to turn at 0.5 rad/s: no RPDO whose deadline could pass.
void DriveBySdo(NodeBench& bench, std::uint32_t deadline_ms) {
  bench.Run(60);
  ASSERT_TRUE(bench.Write(0x1400, 5, 2, deadline_ms));
  ASSERT_TRUE(bench.Write(0x6060, 0, 1, 9));
  for (const std::uint32_t word : {0x06U, 0x07U, 0x0FU}) {
    ASSERT_TRUE(bench.Write(0x6040, 0, 2, word));
  }
  ASSERT_TRUE(bench.Write(0x60FF, 0, 4, 500000));
  bench.Run(60);
  ASSERT_EQ(bench.node.velocity_radps(), 0.5);
}

TEST(Cia402Node, AJointDrivenBySdoAndForgottenIsStoppedAsOneWithoutItsPdu) {
  NodeBench bench;
  DriveBySdo(bench, 100);
  for (int i = 0; i < 5; ++i) {  // told again in time, by either object
    ASSERT_TRUE(i % 2 == 0 ? bench.Write(0x60FF, 0, 4, 500000) : bench.Write(0x6040, 0, 2, 0x0F));
    bench.Run(95);
    ASSERT_EQ(bench.node.drive_state(), DriveState::kOperationEnabled);
  }
  bench.Run(10);
  ASSERT_EQ(bench.node.drive_state(), DriveState::kFaultReaction);
  bench.Run(100);
  EXPECT_EQ(bench.node.drive_state(), DriveState::kFault);
  EXPECT_EQ(bench.node.velocity_radps(), 0);
  EXPECT_EQ(bench.node.dictionary().Value(0x603F, 0), 0x8250U);
}

TEST(Cia402Node, AJointAtRestMayBeLeftEnabledBySdo) {
  NodeBench bench;
  DriveBySdo(bench, 100);
  ASSERT_TRUE(bench.Write(0x60FF, 0, 4, 0));
  bench.Run(1000);
  EXPECT_EQ(bench.node.drive_state(), DriveState::kOperationEnabled);
}

TEST(Cia402Node, WithoutADeadlineTheHeartbeatIsWhatStopsAForgottenJoint) {
  NodeBench bench;
  DriveBySdo(bench, 0);
  ASSERT_TRUE(bench.Write(0x1016, 1, 4, 0x7F << 16 | 300));
  bench.Hear(Bytes(0x77F, {0x05}));
  bench.Run(295);
  EXPECT_EQ(bench.node.velocity_radps(), 0.5);
  bench.Run(100);
  EXPECT_EQ(bench.node.dictionary().Value(0x603F, 0), 0x8130U);
  EXPECT_EQ(bench.node.velocity_radps(), 0);
}

TEST(Cia402Node, TheAbortConnectionOptionChoosesTheReaction) {
  struct Case {
    std::uint32_t option;
    DriveState state;
  };
  for (const Case& c :
       {Case{0, DriveState::kOperationEnabled}, Case{1, DriveState::kFault},
        Case{2, DriveState::kSwitchOnDisabled}, Case{3, DriveState::kSwitchOnDisabled}}) {
    SCOPED_TRACE(c.option);
    NodeBench bench;
    bench.Enable();
    ASSERT_TRUE(bench.Write(0x6007, 0, 2, c.option));
    bench.Cycle(0x0F, 200000);
    bench.Hear(Bytes(0x000, {0x80, 0x01}));
    bench.Run(100);
    EXPECT_EQ(bench.node.drive_state(), c.state);
    EXPECT_EQ(Little(bench.Said(0x081).at(0), 0, 2), 0x8100 - 0x10000);
  }
}

TEST(Cia402Node, ErrorBehaviourMayLeaveOperational) {
  for (const auto& [behaviour, state] :
       {std::pair{0U, NmtState::kPreOperational}, std::pair{1U, NmtState::kOperational},
        std::pair{2U, NmtState::kStopped}}) {
    NodeBench bench;
    bench.Enable();
    ASSERT_TRUE(bench.Write(0x1029, 1, 1, behaviour));
    bench.Run(300);
    EXPECT_EQ(bench.node.nmt(), state);
    EXPECT_EQ(bench.node.drive_state(), DriveState::kFault);
  }
}

TEST(Cia402Node, AnInternalFaultHoldsUntilItIsGone) {
  NodeBench bench;
  bench.Enable();
  bench.node.RaiseInternalFault(0x2310);  // continuous over-current
  bench.Run(20);
  EXPECT_EQ(bench.Said(0x081)[0], Bytes(0x081, {0x10, 0x23, 0x21, 0, 0, 0, 0, 0}));
  bench.Cycle(0x80, 0);
  EXPECT_EQ(bench.node.drive_state(), DriveState::kFault);
  bench.node.ClearInternalFault();
  bench.Cycle(0x00, 0);
  bench.Cycle(0x80, 0);
  EXPECT_EQ(bench.node.drive_state(), DriveState::kSwitchOnDisabled);
}

TEST(Cia402Node, AnInternalFaultOutlivesAResetOfTheNode) {
  NodeBench bench;
  bench.Enable();
  bench.node.RaiseInternalFault(0xFF00, 0x01020304);
  bench.Run(20);
  bench.Hear(Bytes(0x000, {0x81, 0x01}));
  bench.Run(80);
  EXPECT_EQ(bench.node.drive_state(), DriveState::kFault);
  EXPECT_EQ(bench.Said(0x081).back(), Bytes(0x081, {0x00, 0xFF, 0x21, 4, 3, 2, 1, 0}));
  EXPECT_EQ(bench.Said(0x081).size(), 2U);
}

TEST(Cia402Node, SaysNothingUntilItKnowsWhereItStands) {
  Cia402Node node{Cia402Config{}};
  std::vector<can::Frame> said;
  Time now{};
  const auto run = [&](double position_rad) {
    for (int i = 0; i < 200; ++i) {
      node.Measure(position_rad, 0.5);
      node.OnFrame(Bytes(0x000, {0x01, 0x00}), now);
      node.Step(now += milliseconds(1), said);
    }
  };
  run(std::nan(""));
  EXPECT_TRUE(said.empty());
  EXPECT_EQ(node.nmt(), NmtState::kBootUp);
  run(1.25);
  EXPECT_EQ(node.nmt(), NmtState::kOperational);
  EXPECT_EQ(node.dictionary().Value(0x6064, 0), 1250000U);
  EXPECT_EQ(node.dictionary().Value(0x606C, 0), 500000U) << "the measured one: it is at rest";
}

TEST(Cia402Node, WhereTheHostMayNotLoosenItsGuardsItCanMakeThemStricter) {
  const struct {
    int index, sub, bytes;
    std::uint32_t looser, stricter;
  } cases[] = {{0x1400, 5, 2, 0, 20},
               {0x1400, 5, 2, 1001, 1000},
               {0x6007, 0, 2, 0, 3},
               {0x607D, 1, 4, static_cast<std::uint32_t>(-1000001), 0},
               {0x607D, 2, 4, 1000001, 0},
               {0x6080, 0, 4, 31, 10},
               {0x6085, 0, 4, 9999999, 20000000}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.index);
    NodeBench loose(Cia402Config{.lower_rad = -1, .upper_rad = 1});
    loose.Run(60);
    EXPECT_TRUE(loose.Write(c.index, c.sub, c.bytes, c.looser));
    NodeBench held(Cia402Config{.lower_rad = -1, .upper_rad = 1, .host_may_loosen = false});
    held.Run(60);
    EXPECT_FALSE(held.Write(c.index, c.sub, c.bytes, c.looser));
    EXPECT_TRUE(held.Write(c.index, c.sub, c.bytes, c.stricter));
  }
}

TEST(Cia402Node, AShortCommandIsRefusedWithAnEmergency) {
  NodeBench bench;
  bench.Enable();
  bench.Hear(Bytes(0x201, {0x0F, 0x00, 0x20}));
  bench.Tick();
  EXPECT_EQ(Little(bench.Said(0x081).at(0), 0, 2), 0x8210 - 0x10000);
  EXPECT_EQ(bench.node.rejected(), 1);
}

TEST(Cia402Node, NeverTurnsPastItsSoftLimits) {
  NodeBench bench(Cia402Config{.lower_rad = -0.2, .upper_rad = 0.3});
  bench.Enable();
  for (int i = 0; i < 100; ++i) {
    bench.Cycle(0x0F, 3000000);
  }
  EXPECT_LE(bench.position_rad, 0.3);
  EXPECT_NEAR(bench.position_rad, 0.3, 1e-3);
  EXPECT_EQ(bench.Said(0x281).back().data[1] & 0x08, 0x08) << "internal limit";
}

/// A log line's frame; false for a comment.
bool ParseLine(const std::string& line, can::Frame& frame) {
  const std::size_t hash = line.find('#');
  if (line.empty() || line[0] != '(' || hash == std::string::npos) {
    return false;
  }
  frame = {};
  frame.id = static_cast<std::uint32_t>(std::stoul(line.substr(hash - 3, 3), nullptr, 16));
  for (std::size_t i = hash + 1; i + 1 < line.size() && std::isxdigit(line[i]) != 0; i += 2) {
    frame.data[frame.dlc++] = static_cast<std::uint8_t>(std::stoul(line.substr(i, 2), nullptr, 16));
  }
  return true;
}

// The host side of a start-up recorded from another CANopen library, fed to our drive. Every SDO
// answer must be the recorded drive's, byte for byte; its boot-ups, heartbeats and EMCY were driven
// by its own clock and script.
TEST(Cia402Node, AnswersARecordedStartUpByteForByte) {
  std::ifstream log(PIPEWRIGHT_TEST_DATA "/can/canopen_csv_startup.log");
  ASSERT_TRUE(log.is_open());
  NodeBench bench;
  bench.Run(60);
  std::vector<can::Frame> expected;
  int commands = 0;
  for (std::string line; std::getline(log, line);) {
    can::Frame frame;
    if (!ParseLine(line, frame)) {
      continue;
    }
    if (frame.id == 0x581) {
      expected.push_back(frame);
    } else if (frame.id == 0x000 || frame.id == 0x080 || frame.id == 0x201 || frame.id == 0x601) {
      bench.Hear(frame);
      bench.Run(frame.id == 0x000 ? 60 : 1);
      commands += frame.id == 0x201 ? 1 : 0;
    }
    if (frame.id == 0x080 && commands > 0) {
      ASSERT_EQ(bench.node.drive_state(), DriveState::kOperationEnabled);
    }
  }
  ASSERT_EQ(expected.size(), 32U);
  const std::vector<can::Frame> answers = bench.Said(0x581);
  ASSERT_EQ(answers.size(), expected.size());
  for (std::size_t i = 0; i < answers.size(); ++i) {
    EXPECT_EQ(answers[i], expected[i]) << "answer " << i;
  }
  EXPECT_EQ(bench.node.rejected(), 0);
  EXPECT_EQ(commands, 20);
  EXPECT_EQ(bench.node.nmt(), NmtState::kStopped);
  EXPECT_GT(std::abs(bench.position_rad), 1e-6) << "it was told to turn";
}

}  // namespace
}  // namespace pipewright::hil
