// SPDX-License-Identifier: MIT
#include "platform/can/loopback_bus.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "platform/can/bits.h"
#include "platform/core/rng.h"

namespace pipewright::can {
namespace {

using std::chrono_literals::operator""us;
using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""ns;
using std::chrono_literals::operator""s;

/// The frame as a string of '0' and '1', the checksum by long division: slow, and nothing shared
/// with the code under test.
int BitsByText(const Frame& f) {
  const auto binary = [](std::uint32_t value, int bits) {
    std::string text;
    for (int i = bits - 1; i >= 0; --i) {
      text += ((value >> i) & 1) != 0 ? '1' : '0';
    }
    return text;
  };
  std::string bits = binary(0, 1);
  bits += binary(f.extended ? f.id >> 18 : f.id, 11);
  bits += f.extended ? "11" : "";
  bits += f.extended ? binary(f.id & 0x3FFFF, 18) : "";
  bits += f.remote ? "1" : "0";
  bits += "00";
  bits += binary(f.dlc, 4);
  for (int i = 0; i < (f.remote ? 0 : f.dlc); ++i) {
    bits += binary(f.data[static_cast<std::size_t>(i)], 8);
  }
  const std::string generator = "1100010110011001";
  std::string remainder = bits + std::string(15, '0');
  for (std::size_t i = 0; i < bits.size(); ++i) {
    for (std::size_t j = 0; remainder[i] == '1' && j < generator.size(); ++j) {
      if (generator[j] == '1') {
        remainder[i + j] = remainder[i + j] == '1' ? '0' : '1';
        if (j == 0) {
          remainder[i] = '1';  // still the pivot of this pass
        }
      }
    }
    remainder[i] = '0';
  }
  bits += remainder.substr(bits.size());
  std::string sent;
  for (const char bit : bits) {
    sent += bit;
    if (sent.size() >= 5 && sent.find_last_not_of(bit) != sent.size() - 1) {
      const std::size_t other = sent.find_last_not_of(bit);
      const std::size_t run = other == std::string::npos ? sent.size() : sent.size() - 1 - other;
      if (run == 5) {
        sent += bit == '1' ? '0' : '1';
      }
    }
  }
  return static_cast<int>(sent.size()) + 13;
}

Frame RandomFrame(Rng& rng) {
  Frame f{.dlc = static_cast<std::uint8_t>(rng.Index(9)),
          .extended = rng.Index(4) == 0,
          .remote = rng.Index(8) == 0};
  f.id = static_cast<std::uint32_t>(rng.Index(f.extended ? 0x20000000 : 0x800));
  for (int i = 0; i < f.dlc; ++i) {
    const int kind = rng.Index(3);  // zeros and ones are what stuffs
    f.data[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(kind == 0   ? 0
                                                                    : kind == 1 ? 0xFF
                                                                                : rng.Index(256));
  }
  return f;
}

TEST(FrameBits, EqualALongDivisionOnText) {
  Rng rng(1);
  for (int i = 0; i < 5000; ++i) {
    const Frame f = RandomFrame(rng);
    ASSERT_EQ(FrameBits(f), BitsByText(f)) << f.id;
  }
}

TEST(FrameBits, LieBetweenTheNominalAndTheWorstCase) {
  Rng rng(2);
  for (int i = 0; i < 20'000; ++i) {
    Frame f = RandomFrame(rng);
    f.extended = false;
    f.remote = false;
    f.id &= 0x7FF;
    const int nominal = 47 + 8 * f.dlc;
    EXPECT_GE(FrameBits(f), nominal);
    EXPECT_LE(FrameBits(f), nominal + (34 + 8 * f.dlc - 1) / 4);
  }
  // 34 zeros: a stuff bit after every fifth, six in all.
  EXPECT_EQ(FrameBits({.id = 0, .dlc = 0}), 53);
}

class LoopbackTest : public testing::Test {
 protected:
  std::unique_ptr<LoopbackBus> bus_ = std::make_unique<LoopbackBus>(500'000);
  LoopbackBus::Port& a_ = *bus_->Attach();
  LoopbackBus::Port& b_ = *bus_->Attach();
  LoopbackBus::Port& tap_ = *bus_->AttachListener();

  static std::vector<Frame> Drain(LoopbackBus::Port& port) {
    std::vector<Frame> frames;
    Frame frame;
    while (port.Receive(frame)) {
      frames.push_back(frame);
    }
    return frames;
  }
};

TEST_F(LoopbackTest, AFrameReachesAllOthersWhenItsBitsHavePassed) {
  const Frame frame{.id = 0x111, .dlc = 8, .data = {1, 2, 3, 4, 5, 6, 7, 8}};
  ASSERT_EQ(a_.Send(frame), Status::kOk);
  const Duration length = FrameBits(frame) * 2us;
  bus_->AdvanceTo(Time(length - 1ns));
  EXPECT_TRUE(Drain(b_).empty());
  bus_->AdvanceTo(Time(length));
  const std::vector<Frame> at_b = Drain(b_);
  ASSERT_EQ(at_b.size(), 1U);
  EXPECT_EQ(at_b[0], frame);
  EXPECT_EQ(at_b[0].stamp, Time(length));
  EXPECT_EQ(Drain(tap_).size(), 1U);
  EXPECT_TRUE(Drain(a_).empty());
  EXPECT_EQ(a_.counters().tx, 1U);
  EXPECT_EQ(b_.counters().rx, 1U);
}

TEST_F(LoopbackTest, TheLowestIdWinsTheWireButAPortKeepsItsOrder) {
  ASSERT_EQ(a_.Send({.id = 0x300}), Status::kOk);
  ASSERT_EQ(a_.Send({.id = 0x080}), Status::kOk);
  ASSERT_EQ(b_.Send({.id = 0x200}), Status::kOk);
  ASSERT_EQ(b_.Send({.id = 0x400}), Status::kOk);
  bus_->AdvanceTo(Time(10ms));
  std::vector<std::uint32_t> order;
  for (const Frame& f : Drain(tap_)) {
    order.push_back(f.id);
  }
  EXPECT_EQ(order, (std::vector<std::uint32_t>{0x200, 0x300, 0x080, 0x400}));
}

TEST_F(LoopbackTest, AnElevenBitIdBeatsTheLongIdThatBeginsWithIt) {
  ASSERT_EQ(a_.Send({.id = 0x100 << 18, .extended = true}), Status::kOk);
  ASSERT_EQ(b_.Send({.id = 0x100}), Status::kOk);
  bus_->AdvanceTo(Time(10ms));
  const std::vector<Frame> frames = Drain(tap_);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_FALSE(frames[0].extended);
}

TEST_F(LoopbackTest, AFrameQueuedWhileAnotherIsUnderWayWaitsForItsEnd) {
  ASSERT_EQ(a_.Send({.id = 0x7FF, .dlc = 8}), Status::kOk);
  bus_->AdvanceTo(Time(10us));
  ASSERT_EQ(b_.Send({.id = 0x001}), Status::kOk);
  bus_->AdvanceTo(Time(10ms));
  const std::vector<Frame> frames = Drain(tap_);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].id, 0x7FFU);
  EXPECT_EQ(frames[1].stamp - frames[0].stamp, FrameBits(frames[1]) * 2us);
}

TEST_F(LoopbackTest, FullQueuesAreToldAndCounted) {
  for (int i = 0; i < LoopbackBus::kTxCapacity; ++i) {
    ASSERT_EQ(a_.Send({.id = 1}), Status::kOk);
  }
  EXPECT_EQ(a_.Send({.id = 1}), Status::kFull);
  EXPECT_EQ(a_.counters().tx_dropped, 1U);
  for (int i = 0; i < 5; ++i) {
    bus_->AdvanceTo(bus_->now() + 1s);
    for (int j = 0; j < LoopbackBus::kTxCapacity; ++j) {
      ASSERT_EQ(a_.Send({.id = 1}), Status::kOk);
    }
  }
  EXPECT_EQ(Drain(b_).size(), static_cast<std::size_t>(LoopbackBus::kRxCapacity));
  EXPECT_EQ(b_.counters().rx_dropped, 64U);
}

TEST_F(LoopbackTest, WhatNoFrameCanBeIsRefused) {
  EXPECT_EQ(a_.Send({.id = 0x800}), Status::kMalformed);
  EXPECT_EQ(a_.Send({.id = 1, .dlc = 9}), Status::kMalformed);
  EXPECT_EQ(a_.Send({.id = 1, .error = true}), Status::kMalformed);
  EXPECT_EQ(tap_.Send({.id = 1}), Status::kMalformed);
}

TEST_F(LoopbackTest, ACutPortIsSilentAndDeafUntilItIsMended) {
  ASSERT_EQ(a_.Send({.id = 1}), Status::kOk);
  a_.SetCut(true);
  EXPECT_EQ(a_.Send({.id = 2}), Status::kUnavailable);
  bus_->AdvanceTo(Time(1ms));
  EXPECT_TRUE(Drain(b_).empty());
  EXPECT_EQ(a_.counters().tx_dropped, 2U);
  a_.SetCut(false);
  ASSERT_EQ(a_.Send({.id = 3}), Status::kOk);
  bus_->AdvanceTo(Time(2ms));
  EXPECT_EQ(Drain(b_).size(), 1U);
}

TEST_F(LoopbackTest, AFrameCutOffUnderWayIsLost) {
  ASSERT_EQ(a_.Send({.id = 1, .dlc = 8}), Status::kOk);
  bus_->AdvanceTo(Time(50us));
  a_.SetCut(true);
  a_.SetCut(false);
  ASSERT_EQ(a_.Send({.id = 2}), Status::kOk);
  bus_->AdvanceTo(Time(10ms));
  const std::vector<Frame> frames = Drain(b_);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].id, 2U);
}

TEST_F(LoopbackTest, WithNobodyToAcknowledgeAFrameIsSentAgainUntilSomebodyDoes) {
  b_.SetCut(true);
  ASSERT_EQ(a_.Send({.id = 1}), Status::kOk);
  bus_->AdvanceTo(Time(2s));
  EXPECT_TRUE(Drain(tap_).empty());
  EXPECT_GT(bus_->unacknowledged(), 1000U);
  EXPECT_GT(bus_->Load(), 0.99);
  b_.SetCut(false);
  bus_->AdvanceTo(Time(2s + 1ms));
  EXPECT_EQ(Drain(b_).size(), 1U);
  EXPECT_EQ(Drain(tap_).size(), 1U);
}

TEST_F(LoopbackTest, LoadIsTheBusyShareOfTheLastSecond) {
  const Frame frame{.id = 0x111, .dlc = 8, .data = {1, 2, 3, 4, 5, 6, 7, 8}};
  const double expected = 100 * FrameBits(frame) / 500e3;
  for (int i = 0; i < 2000; ++i) {
    if (i % 10 == 0) {
      ASSERT_EQ(a_.Send(frame), Status::kOk);
    }
    bus_->AdvanceTo(bus_->now() + 1ms);
    Drain(b_);
    Drain(tap_);
  }
  EXPECT_NEAR(bus_->Load(), expected, 1e-9);
  EXPECT_NEAR(bus_->PeakLoad(), expected, 1e-9);
  bus_->AdvanceTo(bus_->now() + 2s);
  EXPECT_EQ(bus_->Load(), 0);
  EXPECT_NEAR(bus_->PeakLoad(), expected, 1e-9);
}

TEST(Loopback, ASlowBusSpreadsAFrameOverItsLoadSlots) {
  auto bus = std::make_unique<LoopbackBus>(1000);  // 130 ms a frame
  LoopbackBus::Port& a = *bus->Attach();
  bus->Attach();
  const Frame frame{.id = 0x111, .dlc = 8, .data = {1, 2, 3, 4, 5, 6, 7, 8}};
  ASSERT_EQ(a.Send(frame), Status::kOk);
  bus->AdvanceTo(Time(1s));
  EXPECT_NEAR(bus->Load(), FrameBits(frame) / 1000.0, 1e-9);
}

TEST(Loopback, PortsRunOut) {
  auto bus = std::make_unique<LoopbackBus>(500'000);
  for (int i = 0; i < LoopbackBus::kMaxPorts; ++i) {
    EXPECT_NE(bus->Attach(), nullptr);
  }
  EXPECT_EQ(bus->Attach(), nullptr);
}

TEST(Loopback, HowTimeIsCutIntoStepsChangesNothing) {
  const auto run = [](Duration step) {
    auto bus = std::make_unique<LoopbackBus>(500'000);
    LoopbackBus::Port& a = *bus->Attach();
    LoopbackBus::Port& b = *bus->Attach();
    std::vector<std::int64_t> seen;
    Rng rng(11);
    for (int i = 0; i < 200; ++i) {
      (void)a.Send(RandomFrame(rng));
      (void)b.Send(RandomFrame(rng));
      const Time until(2ms * (i + 1));
      while (bus->now() < until) {
        bus->AdvanceTo(std::min(until, bus->now() + step));
      }
      Frame f;
      while (a.Receive(f) || b.Receive(f)) {
        seen.push_back(f.stamp.time_since_epoch().count() * 4096 + f.id % 4096);
      }
    }
    return seen;
  };
  const std::vector<std::int64_t> whole = run(2ms);
  EXPECT_EQ(whole.size(), 400U);
  EXPECT_EQ(run(1ms), whole);
  EXPECT_EQ(run(37us), whole);
}

}  // namespace
}  // namespace pipewright::can
