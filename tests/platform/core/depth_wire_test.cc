// SPDX-License-Identifier: MIT
#include "platform/core/depth_wire.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

namespace pipewright {
namespace {

std::vector<std::uint8_t> BytesOf(const DepthFrame& frame) {
  std::vector<std::uint8_t> bytes(kDepthFrameMaxBytes);
  bytes.resize(PutDepthFrame(frame, bytes));
  return bytes;
}

std::unique_ptr<DepthFrame> Frame(int width, int height) {
  auto frame = std::make_unique<DepthFrame>();
  frame->stamp = Time{Duration{0x0102030405060708}};
  frame->sequence = 7;
  frame->camera = {width, height, 1.5, 2.5, 0.5, -0.25, 0.125, 6};
  for (int i = 0; i < width * height; ++i) {
    frame->depth_mm[i] = static_cast<std::uint16_t>(1000 + i);
  }
  return frame;
}

TEST(DepthWire, HasTheBytesThatItsHeaderPromises) {
  std::vector<std::uint8_t> bytes = BytesOf(*Frame(2, 1));
  ASSERT_EQ(bytes.size(), kDepthHeadBytes + 4);
  const std::vector<std::uint8_t> head(bytes.begin(), bytes.begin() + 32);
  EXPECT_EQ(head, (std::vector<std::uint8_t>{'P', 'W', 'Z', '1', 7, 0, 0,    0,  //
                                             8,   7,   6,   5,   4, 3, 2,    1,  // stamp
                                             2,   0,   0,   0,   1, 0, 0,    0,  // width, height
                                             0,   0,   0,   0,   0, 0, 0xF8, 0x3F}));  // fx 1.5
  EXPECT_EQ(std::vector<std::uint8_t>(bytes.end() - 4, bytes.end()),
            (std::vector<std::uint8_t>{0xE8, 3, 0xE9, 3}));
}

TEST(DepthWire, GivesBackWhatWasPut) {
  const auto sent = Frame(6, 4);
  std::vector<std::uint8_t> bytes = BytesOf(*sent);
  const auto heard = std::make_unique<DepthFrame>();
  const std::span<const std::uint8_t> all(bytes);
  ASSERT_EQ(TakeDepthHead(all.first<kDepthHeadBytes>(), *heard), Status::kOk);
  ASSERT_EQ(PixelBytes(*heard), bytes.size() - kDepthHeadBytes);
  TakePixels(all.subspan(kDepthHeadBytes), *heard);
  EXPECT_EQ(heard->stamp, sent->stamp);
  EXPECT_EQ(heard->sequence, sent->sequence);
  EXPECT_EQ(heard->camera.fy, 2.5);
  EXPECT_EQ(heard->camera.cy, -0.25);
  EXPECT_EQ(heard->camera.z_max_m, 6);
  EXPECT_TRUE(
      std::equal(sent->depth_mm.begin(), sent->depth_mm.begin() + 24, heard->depth_mm.begin()));
}

TEST(DepthWire, WhatIsNoFrameIsRefusedAndLeavesTheOldOne) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const struct {
    const char* what;
    CameraIntrinsics camera;
  } cases[] = {
      {"no pixels", {0, 4, 1, 1, 0, 0, 0, 6}},
      {"more than there is room for", {849, 480, 1, 1, 0, 0, 0, 6}},
      {"a product that overflows", {-1, -1, 1, 1, 0, 0, 0, 6}},
      {"no focal length", {2, 1, 0, 1, 0, 0, 0, 6}},
      {"not a number", {2, 1, 1, nan, 0, 0, 0, 6}},
      {"no range", {2, 1, 1, 1, 0, 0, 6, 6}},
  };
  const auto old = Frame(2, 1);
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    auto frame = Frame(1, 1);
    std::vector<std::uint8_t> bytes = BytesOf(*frame);
    // Only the head is written anew: some of these have no pixels that could be put.
    frame->camera = c.camera;
    const auto put = [&](std::size_t at, auto value) {
      const auto* from = reinterpret_cast<const std::uint8_t*>(&value);
      std::copy(from, from + sizeof value, bytes.begin() + static_cast<std::ptrdiff_t>(at));
    };
    put(16, c.camera.width);
    put(20, c.camera.height);
    put(24, c.camera.fx);
    put(32, c.camera.fy);
    put(56, c.camera.z_min_m);
    const auto heard = std::make_unique<DepthFrame>(*old);
    EXPECT_EQ(TakeDepthHead(std::span<const std::uint8_t>(bytes).first<kDepthHeadBytes>(), *heard),
              Status::kMalformed);
    EXPECT_EQ(heard->stamp, old->stamp);
    EXPECT_EQ(heard->camera.width, 2);
  }
  std::vector<std::uint8_t> bytes = BytesOf(*old);
  bytes[3] = '2';
  const auto heard = std::make_unique<DepthFrame>();
  EXPECT_EQ(TakeDepthHead(std::span<const std::uint8_t>(bytes).first<kDepthHeadBytes>(), *heard),
            Status::kMalformed);
}

}  // namespace
}  // namespace pipewright
