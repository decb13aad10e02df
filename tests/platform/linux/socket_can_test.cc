// SPDX-License-Identifier: MIT
#include "platform/linux/socket_can.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>

#include "platform/core/rng.h"

namespace pipewright {
namespace {

TEST(KernelFrame, CarriesTheKernelsFlagBits) {
  struct Case {
    can::Frame frame;
    canid_t can_id;
  };
  const Case kCases[] = {
      {{.id = 0x111, .dlc = 2, .data = {1, 2}}, 0x00000111},
      {{.id = 0x111, .dlc = 2, .extended = true, .data = {1, 2}}, 0x80000111},
      {{.id = 0x7FF, .dlc = 4, .remote = true}, 0x400007FF},
      {{.id = 0x1FFFFFFF, .extended = true, .remote = true}, 0xDFFFFFFF},
      {{.id = 0x00000040, .dlc = 8, .error = true}, 0x20000040},
  };
  for (const Case& c : kCases) {
    const can_frame kernel = ToKernel(c.frame);
    EXPECT_EQ(kernel.can_id, c.can_id);
    EXPECT_EQ(kernel.can_dlc, c.frame.dlc);
    EXPECT_TRUE(std::equal(c.frame.data.begin(), c.frame.data.end(), kernel.data));
    EXPECT_EQ(FromKernel(kernel), c.frame);
  }
}

TEST(KernelFrame, WhateverTheKernelHandsOverIsAFrameOfOurs) {
  Rng rng(1);
  for (int i = 0; i < 20'000; ++i) {
    can_frame kernel{};
    kernel.can_id = static_cast<canid_t>(rng.Next());
    kernel.can_dlc = static_cast<__u8>(rng.Index(16));
    for (__u8& byte : kernel.data) {
      byte = static_cast<__u8>(rng.Next());
    }
    const can::Frame frame = FromKernel(kernel);
    EXPECT_LE(frame.dlc, 8);
    EXPECT_LE(frame.id, frame.extended || frame.error ? 0x1FFFFFFFU : 0x7FFU);
    EXPECT_EQ(FromKernel(ToKernel(frame)), frame);
  }
}

TEST(SocketCan, OpeningWhatIsNotThereSaysWhyAndLeavesItClosed) {
  SocketCan bus;
  EXPECT_EQ(bus.Open("nosuchcan0"), Status::kUnavailable);
  EXPECT_FALSE(bus.is_open());
  EXPECT_NE(bus.error_number(), 0);
  EXPECT_NE(std::string(bus.error_text()).find(std::strerror(bus.error_number())),
            std::string::npos)
      << bus.error_text();
}

TEST(SocketCan, NamesThatNoInterfaceCanHaveAreMalformed) {
  SocketCan bus;
  EXPECT_EQ(bus.Open(""), Status::kMalformed);
  EXPECT_EQ(bus.Open("sixteen_letters_"), Status::kMalformed);
  EXPECT_FALSE(bus.error_text().empty());
}

TEST(SocketCan, ClosedItNeitherSendsNorReceives) {
  SocketCan bus;
  can::Frame frame{.id = 1};
  EXPECT_EQ(bus.Send(frame), Status::kUnavailable);
  EXPECT_EQ(bus.tx_dropped(), 1U);
  EXPECT_FALSE(bus.Receive(frame));
  EXPECT_FALSE(bus.healthy());
  EXPECT_EQ(bus.Send({.id = 0x800}), Status::kMalformed);
  EXPECT_EQ(bus.Send({.id = 1, .dlc = 9}), Status::kMalformed);
  EXPECT_EQ(bus.Send({.id = 1, .error = true}), Status::kMalformed);
}

TEST(SocketCan, SendsToAndHearsItselfOverAVirtualInterface) {
  SocketCan a;
  SocketCan b;
  if (a.Open("vcan0") != Status::kOk || b.Open("vcan0") != Status::kOk) {
    GTEST_SKIP() << "no vcan0 here: " << a.error_text();
  }
  const can::Frame sent{.id = 0x123, .dlc = 3, .data = {1, 2, 3}};
  ASSERT_EQ(a.Send(sent), Status::kOk);
  can::Frame heard;
  ASSERT_TRUE(b.Receive(heard));
  EXPECT_EQ(heard, sent);
  EXPECT_GT(heard.stamp, Time{});
}

}  // namespace
}  // namespace pipewright
