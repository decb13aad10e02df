// SPDX-License-Identifier: MIT
// What SocketCan does when the kernel's interface misbehaves. These change the interface vcan1, so
// they run only inside scripts/can-vm, which has one for nobody else.
#include <gtest/gtest.h>

#include <cerrno>
#include <cstdlib>
#include <string>

#include "platform/linux/clock.h"
#include "platform/linux/socket_can.h"

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;

constexpr const char* kInterface = "vcan1";

class KernelCan : public testing::Test {
 protected:
  void SetUp() override {
    if (std::getenv("CAN_VM") == nullptr) {
      GTEST_SKIP() << "not inside scripts/can-vm";
    }
    ASSERT_EQ(bus_.Open(kInterface), Status::kOk) << bus_.error_text();
    ASSERT_EQ(peer_.Open(kInterface), Status::kOk) << peer_.error_text();
  }
  void TearDown() override {
    if (std::getenv("CAN_VM") != nullptr) {
      Shell("tc qdisc del dev vcan1 root 2>/dev/null; ip link set vcan1 up");
    }
  }

  static void Shell(const std::string& line) { EXPECT_NE(std::system(line.c_str()), -1) << line; }
  static int Drain(SocketCan& bus) {
    can::Frame frame;
    int count = 0;
    while (bus.Receive(frame)) {
      ++count;
    }
    return count;
  }

  SocketCan bus_;
  SocketCan peer_;
};

TEST_F(KernelCan, AFullReceiveQueueDropsAndCounts) {
  constexpr int kSent = 5000;
  for (int i = 0; i < kSent; ++i) {
    ASSERT_EQ(peer_.Send({.id = 0x123}), Status::kOk);
  }
  const int heard = Drain(bus_);
  EXPECT_GT(heard, 50);
  EXPECT_LT(heard, kSent);
  EXPECT_EQ(bus_.rx_dropped(), 0U) << "the kernel tells with the next frame that it does take";
  ASSERT_EQ(peer_.Send({.id = 0x124}), Status::kOk);
  EXPECT_EQ(Drain(bus_), 1);
  EXPECT_EQ(bus_.rx_dropped(), static_cast<std::uint64_t>(kSent - heard));
  EXPECT_TRUE(bus_.healthy());
}

TEST_F(KernelCan, AReceiveQueueCanBeMadeToHoldMore) {
  constexpr int kSent = 5000;
  bus_.GrowReceiveQueue(8192);
  for (int i = 0; i < kSent; ++i) {
    ASSERT_EQ(peer_.Send({.id = 0x123}), Status::kOk);
  }
  EXPECT_EQ(Drain(bus_), kSent);
}

TEST_F(KernelCan, DiscardingForgetsWhatCameAndWhatWasLost) {
  for (int i = 0; i < 5000; ++i) {
    ASSERT_EQ(peer_.Send({.id = 0x123}), Status::kOk);
  }
  bus_.Discard();
  EXPECT_EQ(Drain(bus_), 0);
  ASSERT_EQ(peer_.Send({.id = 0x124}), Status::kOk);
  EXPECT_EQ(Drain(bus_), 1);
  EXPECT_EQ(bus_.rx_dropped(), 0U);
}

TEST_F(KernelCan, AFullTransmitQueueDropsAndCounts) {
  Shell("tc qdisc add dev vcan1 root tbf rate 8kbit burst 32 limit 160");
  int full = 0;
  for (int i = 0; i < 100; ++i) {
    const Status status = bus_.Send({.id = 0x123, .dlc = 8});
    full += status == Status::kFull ? 1 : 0;
    EXPECT_TRUE(status == Status::kFull || status == Status::kOk) << Name(status);
  }
  EXPECT_GT(full, 50);
  EXPECT_EQ(bus_.tx_dropped(), static_cast<std::uint64_t>(full));
  EXPECT_TRUE(bus_.healthy()) << "a full queue is no broken wire";
}

TEST_F(KernelCan, ErrorFramesComeAsSuch) {
  Shell("cansend vcan1 20000040#0000000000000000");
  can::Frame frame;
  ASSERT_TRUE(bus_.Receive(frame));
  EXPECT_TRUE(frame.error);
  EXPECT_EQ(frame.id, 0x40U);  // CAN_ERR_BUSOFF
}

TEST_F(KernelCan, ALinkThatWasDownNeedsNoNewSocket) {
  Shell("ip link set vcan1 down");
  can::Frame frame;
  EXPECT_FALSE(bus_.Receive(frame));
  EXPECT_FALSE(bus_.healthy());
  EXPECT_EQ(bus_.error_number(), ENETDOWN);
  EXPECT_EQ(bus_.Send({.id = 0x123}), Status::kUnavailable);
  EXPECT_EQ(bus_.tx_dropped(), 1U);
  Shell("ip link set vcan1 up");
  EXPECT_EQ(bus_.Send({.id = 0x123}), Status::kOk);
  EXPECT_TRUE(bus_.healthy());
  Drain(peer_);  // it first tells that the link was down
  EXPECT_EQ(bus_.Send({.id = 0x124}), Status::kOk);
  EXPECT_GE(Drain(peer_), 1);
  EXPECT_TRUE(peer_.healthy());
}

TEST_F(KernelCan, OpeningWhatIsDownOrNotCanSaysSo) {
  Shell("ip link set vcan1 down");
  SocketCan bus;
  EXPECT_EQ(bus.Open(kInterface), Status::kUnavailable);
  EXPECT_EQ(bus.error_number(), ENETDOWN);
  EXPECT_FALSE(bus.is_open());
  EXPECT_EQ(bus.Open("lo"), Status::kUnavailable);
  EXPECT_NE(bus.error_text().find("not a CAN interface"), std::string_view::npos)
      << bus.error_text();
  EXPECT_FALSE(bus.is_open());
}

}  // namespace
}  // namespace pipewright
