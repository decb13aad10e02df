// SPDX-License-Identifier: MIT
#include "hil/xarm/xarm_protocol.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>
#include <vector>

namespace pipewright::hil {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes FromHex(const std::string& hex) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += hex[i] == ' ' ? 1 : 2) {
    if (hex[i] != ' ') {
      bytes.push_back(static_cast<std::uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16)));
    }
  }
  return bytes;
}

Bytes Encoded(XarmFrame frame) {
  frame.transaction = 1;
  std::array<std::uint8_t, XarmFrame::kBytesMax> room{};
  const std::size_t size = EncodeXarmFrame(frame, room);
  return {room.begin(), room.begin() + static_cast<std::ptrdiff_t>(size)};
}

// Bytes as UFACTORY's pages print them (ufactory_docs, communication_protocol/p05, p08).
TEST(XarmRequest, IsTheManualsBytes) {
  EXPECT_EQ(Encoded(XarmMotionEnable(true)), FromHex("00 01 00 02 00 03 0B 08 01"));
  EXPECT_EQ(Encoded(XarmSetState(xarm_state::kReady)), FromHex("00 01 00 02 00 02 0C 00"));
  EXPECT_EQ(Encoded(XarmAsk(XarmRegister::kGetState)), FromHex("00 01 00 02 00 01 0D"));
  EXPECT_EQ(Encoded(XarmAsk(XarmRegister::kGetError)), FromHex("00 01 00 02 00 01 0F"));
  EXPECT_EQ(Encoded(XarmAsk(XarmRegister::kCleanError)), FromHex("00 01 00 02 00 01 10"));
  EXPECT_EQ(Encoded(XarmAsk(XarmRegister::kCleanWarning)), FromHex("00 01 00 02 00 01 11"));
  EXPECT_EQ(Encoded(XarmSetMode(xarm_mode::kJointVelocity)), FromHex("00 01 00 02 00 02 13 04"));
  EXPECT_EQ(Encoded(XarmAsk(XarmRegister::kVersion)), FromHex("00 01 00 02 00 01 01"));
}

// p14, register 81. The page's floats are cut, not rounded: -0.1 and 0.2 end in one bit less.
const char* const kVelocityExample =
    "00 01 00 02 00 22 51 91 0A 06 3F CC CC CC BD 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 "
    "00 00 00 00 01 CC CC 4C 3E";

TEST(XarmVelocity, ReadsTheManualsExample) {
  const Result<XarmFrame> frame = DecodeXarmFrame(FromHex(kVelocityExample));
  ASSERT_TRUE(frame.ok());
  const Result<XarmVelocity> velocity = DecodeXarmVelocity(*frame);
  ASSERT_TRUE(velocity.ok());
  EXPECT_NEAR(velocity->velocity_radps(0), 0.5235988, 1e-6);
  EXPECT_NEAR(velocity->velocity_radps(1), -0.1, 1e-7);
  EXPECT_TRUE(velocity->velocity_radps.tail<5>().isZero(0));
  EXPECT_TRUE(velocity->together);
  EXPECT_NEAR(velocity->duration_s, 0.2, 1e-7);
}

TEST(XarmVelocity, IsWrittenAsTheManualsExampleButForTheCutBits) {
  XarmVelocity velocity{.duration_s = 0.2};
  velocity.velocity_radps << 0.52359872, -0.1, 0, 0, 0, 0, 0;
  const Result<XarmFrame> frame = XarmVelocityRequest(velocity);
  ASSERT_TRUE(frame.ok());
  Bytes expected = FromHex(kVelocityExample);
  expected[11] = 0xCD;
  expected[36] = 0xCD;
  EXPECT_EQ(Encoded(*frame), expected);
}

TEST(XarmVelocity, NoRequestIsUnboundedOrNotANumber) {
  const double inf = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {nan, inf, -inf, 3.2, -3.2}) {
    for (int joint = 0; joint < kXarmJoints; ++joint) {
      XarmVelocity velocity{.duration_s = 0.03};
      velocity.velocity_radps(joint) = bad;
      EXPECT_EQ(XarmVelocityRequest(velocity).status(), Status::kOutOfRange) << bad;
    }
  }
  for (const double bad : {nan, inf, 0.0, -1.0, 1.5}) {
    EXPECT_EQ(XarmVelocityRequest({.duration_s = bad}).status(), Status::kOutOfRange) << bad;
  }
}

TEST(XarmVelocity, OfANumberThatIsNoneOrOfAnotherLengthIsRefused) {
  Bytes bytes = FromHex(kVelocityExample);
  bytes[10] = 0x7F;  // 0x7F060A91 is huge, 0x7FC... would be no number
  bytes[9] = 0xC0;
  Result<XarmFrame> frame = DecodeXarmFrame(bytes);
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(DecodeXarmVelocity(*frame).status(), Status::kOutOfRange);
  frame = DecodeXarmFrame(FromHex(kVelocityExample));
  ASSERT_TRUE(frame.ok());
  for (const std::size_t size : {0, 1, 28, 30, 32, 34}) {
    XarmFrame cut = *frame;
    cut.size = size;
    EXPECT_EQ(DecodeXarmVelocity(cut).status(), Status::kMalformed) << size;
  }
  XarmFrame endless = *frame;  // firmware before 1.8.0: no duration
  endless.size = 29;
  ASSERT_TRUE(DecodeXarmVelocity(endless).ok());
  EXPECT_EQ(DecodeXarmVelocity(endless)->duration_s, 0);
}

// p07, register 1.
TEST(XarmVersion, ReadsTheManualsExample) {
  const Result<XarmFrame> frame = DecodeXarmFrame(
      FromHex("00 01 00 02 00 2A 01 00 36 2C 36 2C 58 49 31 32 30 32 2C 41 43 31 33 30 32 2C 76 31 "
              "2E 31 32 2E 31 30 00 00 00 00 00 00 00 00 00 00 00 00 00 00"));
  ASSERT_TRUE(frame.ok());
  const Result<XarmVersion> version = DecodeXarmVersion(*frame);
  ASSERT_TRUE(version.ok());
  EXPECT_EQ(version->axes, 6);
  EXPECT_EQ(version->major, 1);
  EXPECT_EQ(version->minor, 12);
  EXPECT_EQ(version->revision, 10);
  EXPECT_TRUE(version->AtLeast(1, 8, 0));
  EXPECT_TRUE(version->AtLeast(1, 12, 10));
  EXPECT_FALSE(version->AtLeast(1, 12, 11));
  EXPECT_FALSE(version->AtLeast(2, 1, 0));
}

TEST(XarmVersion, OfAnotherShapeIsRefused) {
  for (const std::string text : {"", "v", "7,7,XI,AC", "7,7,XI,AC,v1", "7,7,XI,AC,v1.x.3", "v1.2.3",
                                 "-7,7,XI,AC,v1.2.3", "7,7,XI,AC,v1.2.-3"}) {
    const XarmFrame response =
        XarmResponse(XarmAsk(XarmRegister::kVersion), 0,
                     {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    EXPECT_EQ(DecodeXarmVersion(response).status(), Status::kMalformed) << text;
  }
}

// p08, register 15.
TEST(XarmErrors, AreTheSecondAndThirdByteOfTheAnswer) {
  const Result<XarmFrame> frame = DecodeXarmFrame(FromHex("00 01 00 02 00 04 0F 60 17 0B"));
  ASSERT_TRUE(frame.ok());
  const Result<XarmErrors> errors = DecodeXarmErrors(*frame);
  ASSERT_TRUE(errors.ok());
  EXPECT_EQ(errors->error, 0x17);
  EXPECT_EQ(errors->warning, 0x0B);
  XarmFrame cut = *frame;
  cut.size = 2;
  EXPECT_EQ(DecodeXarmErrors(cut).status(), Status::kMalformed);
}

TEST(XarmFrame, TellsItsLengthFromItsHeaderAlone) {
  const Bytes bytes = FromHex("00 01 00 02 00 02 0B 10");
  for (std::size_t have = 0; have < 6; ++have) {
    const Result<std::size_t> size = XarmFrameBytes(std::span(bytes).first(have));
    ASSERT_TRUE(size.ok());
    EXPECT_EQ(*size, 0u);
  }
  EXPECT_EQ(*XarmFrameBytes(bytes), 8u);
  for (std::size_t have = 0; have < 8; ++have) {
    EXPECT_EQ(DecodeXarmFrame(std::span(bytes).first(have)).status(), Status::kMalformed);
  }
  EXPECT_EQ(XarmFrameBytes(FromHex("00 01 00 02 00 00")).status(), Status::kMalformed);
  EXPECT_EQ(XarmFrameBytes(FromHex("00 01 00 02 00 FC")).status(), Status::kMalformed);
  EXPECT_TRUE(XarmFrameBytes(FromHex("00 01 00 02 00 FB")).ok());
}

TEST(XarmFrame, AnyBytesAreEitherRefusedOrReadAsTheyStand) {
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes(random() % 300);
    for (std::uint8_t& byte : bytes) {
      byte = static_cast<std::uint8_t>(random());
    }
    if (bytes.size() >= 7 && i % 2 == 0) {  // of the length that it says
      bytes[4] = 0;
      bytes[5] = static_cast<std::uint8_t>(bytes.size() - 6);
    }
    const Result<XarmFrame> frame = DecodeXarmFrame(bytes);
    if (!frame.ok()) {
      continue;
    }
    std::array<std::uint8_t, XarmFrame::kBytesMax> room{};
    const std::size_t size = EncodeXarmFrame(*frame, room);
    EXPECT_EQ(Bytes(room.begin(), room.begin() + static_cast<std::ptrdiff_t>(size)), bytes);
    (void)DecodeXarmVelocity(*frame).ok();
    (void)DecodeXarmErrors(*frame).ok();
    (void)DecodeXarmVersion(*frame).ok();
  }
}

}  // namespace
}  // namespace pipewright::hil
