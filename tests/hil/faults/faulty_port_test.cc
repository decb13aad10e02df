// SPDX-License-Identifier: MIT
#include "hil/faults/faulty_port.h"

#include <gtest/gtest.h>

#include "hil/faults/fault_script.h"
#include "platform/can/loopback_bus.h"

namespace pipewright::hil {
namespace {

using std::chrono_literals::operator""ms;

/// Two nodes, one of them through a faulty port. A frame is its first byte.
struct Wire {
  void Say(std::uint32_t id, int byte) {
    can::Frame frame{.id = id, .dlc = 1};
    frame.data[0] = static_cast<std::uint8_t>(byte);
    ASSERT_EQ(other.Send(frame), Status::kOk);
    Tick();
  }
  void Tick(int ms = 1) {
    for (int i = 0; i < ms; ++i) {
      bus.AdvanceTo(now += 1ms);
      port.AdvanceTo(now);
    }
  }
  std::vector<int> Heard() {
    std::vector<int> bytes;
    for (can::Frame frame; port.Receive(frame);) {
      bytes.push_back(frame.data[0]);
      stamps.push_back(frame.stamp);
    }
    return bytes;
  }

  can::LoopbackBus bus{500'000};
  can::LoopbackBus::Port& near = *bus.Attach();
  can::LoopbackBus::Port& other = *bus.Attach();
  PortOf<can::LoopbackBus::Port> inner{near};
  FaultyPort port{inner};
  Time now{};
  std::vector<Time> stamps;
};

bool Any(const can::Frame&) { return true; }

TEST(FaultyPort, WithoutAFaultIsTheInnerPort) {
  Wire wire;
  wire.Say(1, 10);
  wire.Say(2, 20);
  EXPECT_EQ(wire.Heard(), (std::vector{10, 20}));
  EXPECT_LT(wire.stamps[0], Time{1ms});
  EXPECT_EQ(wire.port.Send({.id = 3}), Status::kOk);
  wire.Tick();
  can::Frame frame;
  EXPECT_TRUE(wire.other.Receive(frame));
  EXPECT_EQ(frame.id, 3U);
}

TEST(FaultyPort, LosesAsManyAsItIsToldThatMatch) {
  Wire wire;
  wire.port.Lose(2, [](const can::Frame& f) { return f.id == 1; });
  for (const int byte : {10, 11, 12, 13}) {
    wire.Say(1, byte);
    wire.Say(2, byte + 10);
  }
  EXPECT_EQ(wire.Heard(), (std::vector{20, 21, 12, 22, 13, 23}));
  EXPECT_EQ(wire.port.counters().lost, 2U);
}

TEST(FaultyPort, DuplicatesSwapsAndDelaysWithTheStampOfTheirComing) {
  Wire wire;
  wire.port.Duplicate(1, Any);
  wire.Say(1, 10);
  EXPECT_EQ(wire.Heard(), (std::vector{10, 10}));
  wire.port.Swap([](const can::Frame& f) { return f.id == 1; });
  wire.Say(1, 11);
  wire.Say(2, 20);
  wire.Say(1, 12);
  wire.Say(1, 13);
  EXPECT_EQ(wire.Heard(), (std::vector{20, 12, 11, 13}));
  EXPECT_GT(wire.stamps[3], wire.stamps[4]);
  wire.port.Delay(1, 5ms, Any);
  wire.Say(1, 14);
  wire.Say(1, 15);
  EXPECT_EQ(wire.Heard(), (std::vector{15}));
  wire.Tick(4);
  EXPECT_EQ(wire.Heard(), (std::vector{14}));
  EXPECT_LT(wire.stamps.back(), wire.now - 4ms);
}

TEST(FaultyPort, InsertsAndReplaysStampedNow) {
  Wire wire;
  Rng rng(1);
  EXPECT_FALSE(wire.port.Replay(rng));
  wire.Say(1, 10);
  wire.Tick(20);
  EXPECT_TRUE(wire.port.Replay(rng));
  wire.port.Insert({.id = 0x40, .error = true});
  wire.Tick();
  EXPECT_EQ(wire.Heard(), (std::vector{10, 10, 0}));
  EXPECT_EQ(wire.stamps[1], wire.now);
  wire.port.SetStampOffset(std::chrono::hours(1));
  wire.Say(1, 11);
  wire.Heard();
  EXPECT_GT(wire.stamps.back(), wire.now + std::chrono::minutes(59));
}

TEST(FaultyPort, RefusesHearsNothingAndDropsTheNewest) {
  Wire wire;
  wire.port.SetSend(Status::kFull);
  EXPECT_EQ(wire.port.Send({}), Status::kFull);
  wire.port.SetSend(Status::kOk);
  wire.port.SetDown(true);
  EXPECT_EQ(wire.port.Send({}), Status::kUnavailable);
  wire.Say(1, 10);
  EXPECT_TRUE(wire.Heard().empty());
  wire.port.SetDown(false);
  EXPECT_EQ(wire.port.counters().tx_refused, 2U);
  for (int i = 0; i < FaultyPort::kRxCapacity + 3; ++i) {
    wire.Say(1, i & 0xFF);
  }
  EXPECT_EQ(wire.Heard().back(), FaultyPort::kRxCapacity - 1);
  EXPECT_EQ(wire.port.counters().rx_dropped, 3U);
}

TEST(FaultScript, DoesEachThingOnceInItsOrder) {
  FaultScript script;
  std::vector<int> done;
  script.At(Time{20ms}, [&] { done.push_back(2); });
  script.At(Time{10ms}, [&] {
    done.push_back(1);
    script.At(Time{15ms}, [&] { done.push_back(3); });
  });
  script.AdvanceTo(Time{9ms});
  EXPECT_TRUE(done.empty());
  script.AdvanceTo(Time{12ms});
  EXPECT_EQ(done, (std::vector{1}));
  script.AdvanceTo(Time{30ms});
  EXPECT_EQ(done, (std::vector{1, 3, 2}));
  EXPECT_TRUE(script.done());
}

}  // namespace
}  // namespace pipewright::hil
