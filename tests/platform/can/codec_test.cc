// SPDX-License-Identifier: MIT
#include "platform/can/codec.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <tuple>

#include "platform/can/cia402.h"
#include "platform/can/cia402_state.h"
#include "platform/can/docs.h"
#include "platform/can/sdo.h"
#include "platform/can/tracer.h"
#include "platform/core/rng.h"

namespace pipewright::can {
namespace {

constexpr auto kBothTables = std::tuple_cat(kTracerTable, kArmTable);
// Base and arm may share a bus: no id means two things.
static_assert(WellFormed(kBothTables));

struct Msg {
  double a = 0;
  double b = 0;
  std::uint32_t c = 0;
};

template <typename F>
void ForEachSignal(F&& f) {
  ForEachRow(kBothTables, [&](const auto& row) {
    for (const auto& s : row.signals) {
      SCOPED_TRACE(std::string(row.head.name) + "." + std::string(s.name));
      f(row, s, row.head.max_node > 0 ? row.head.max_node : 0);
    }
  });
}

TEST(Codec, EverySignalSurvivesTheRoundTripToHalfALsb) {
  ForEachSignal([](const auto& row, const auto& s, int node) {
    for (const double value :
         {s.min, s.min + s.scale, (s.min + s.max) / 2, s.max - s.scale, s.max}) {
      typename std::decay_t<decltype(row)>::Message msg{};
      s.field.Set(msg, std::max(s.min, value));
      const Result<Frame> frame = Encode(row, msg, node);
      ASSERT_TRUE(frame.ok()) << value;
      const auto back = Decode(row, *frame);
      ASSERT_TRUE(back.ok()) << value;
      EXPECT_NEAR(s.field.Get(*back), s.field.Get(msg), s.scale / 2 + 1e-9);
    }
  });
}

TEST(Codec, NoSignalCanBeSentOutsideItsLimits) {
  ForEachSignal([](const auto& row, const auto& s, int node) {
    constexpr double kInf = std::numeric_limits<double>::infinity();
    for (const double value : {s.min - s.scale, s.max + s.scale, kInf, -kInf, 1e300,
                               std::numeric_limits<double>::quiet_NaN()}) {
      if (s.field.is_code && !(value >= 0 && value < 0x1p32)) {
        continue;  // a code cannot even hold it
      }
      typename std::decay_t<decltype(row)>::Message msg{};
      s.field.Set(msg, value);
      EXPECT_EQ(Encode(row, msg, node).status(), Status::kOutOfRange) << value;
    }
  });
}

TEST(Codec, NoSignalIsTakenOutsideItsLimits) {
  Frame frame{.id = 0x111, .dlc = 8, .data = {0x07, 0x09}};  // 1801: 1.801 m/s
  EXPECT_EQ(Decode(kBaseTwistCommand, frame).status(), Status::kOutOfRange);
  frame.data[1] = 0x08;
  EXPECT_TRUE(Decode(kBaseTwistCommand, frame).ok());
  EXPECT_EQ(Decode(kBaseState, {.id = 0x211, .dlc = 8, .data = {3}}).status(), Status::kOutOfRange);
}

TEST(Codec, OtherIdsLengthsAndKindsAreMalformed) {
  const Frame good{.id = 0x211, .dlc = 8};
  ASSERT_TRUE(Decode(kBaseState, good).ok());
  Frame bad = good;
  bad.id = 0x212;
  EXPECT_EQ(Decode(kBaseState, bad).status(), Status::kMalformed);
  for (std::uint8_t dlc = 0; dlc < 8; ++dlc) {
    bad = good;
    bad.dlc = dlc;
    EXPECT_EQ(Decode(kBaseState, bad).status(), Status::kMalformed);
  }
  bad = good;
  bad.extended = true;
  EXPECT_EQ(Decode(kBaseState, bad).status(), Status::kMalformed);
  bad = good;
  bad.remote = true;
  EXPECT_EQ(Decode(kBaseState, bad).status(), Status::kMalformed);
  bad = good;
  bad.error = true;
  EXPECT_EQ(Decode(kBaseState, bad).status(), Status::kMalformed);
}

TEST(Codec, NodesAreAddressedFromOneToTheLast) {
  EXPECT_EQ(Encode(kJointCommand, {}, 0).status(), Status::kOutOfRange);
  EXPECT_EQ(Encode(kJointCommand, {}, 8).status(), Status::kOutOfRange);
  EXPECT_EQ(Encode(kJointCommand, {}, -1).status(), Status::kOutOfRange);
  EXPECT_EQ(Encode(kBaseState, {}, 1).status(), Status::kOutOfRange);
  EXPECT_EQ(Encode(kJointCommand, {}, 7)->id, 0x207U);
  EXPECT_EQ(Encode(kHeartbeat, {.state = 5}, kHostNode)->id, 0x77FU);
  EXPECT_EQ(NodeOf(kEmergency.head, 0x080), -1);  // SYNC
  EXPECT_EQ(NodeOf(kEmergency.head, 0x087), 7);
}

TEST(Codec, WrongRowsAreNotWellFormed) {
  constexpr FrameHead kHead{"row", 0x100, 0, 8, 8, {}, ByteOrder::kBigEndian, Direction::kToDevice};
  using Row = FrameSpec<Msg, 1>;
  const auto with = [&](Signal<Msg> s) { return WellFormed(Row{kHead, {{s}}}); };
  EXPECT_TRUE(with({"a", "1", kField<&Msg::a>, 0, 16, Sign::kSigned, 0.5, -16384, 16383.5}));
  EXPECT_FALSE(with({"limit", "1", kField<&Msg::a>, 0, 16, Sign::kSigned, 0.5, -16384, 16384}));
  EXPECT_FALSE(with({"limit", "1", kField<&Msg::a>, 0, 16, Sign::kUnsigned, 1, -1, 1}));
  EXPECT_FALSE(with({"past the end", "1", kField<&Msg::a>, 56, 16, Sign::kSigned, 1, 0, 1}));
  // What is sent holds all; a second form may be longer, which no signal can tell, or shorter.
  FrameHead short_head = kHead;
  short_head.dlc = 1;
  const Signal<Msg> second_byte{"b", "1", kField<&Msg::b>, 8, 8, Sign::kUnsigned, 1, 0, 1};
  EXPECT_FALSE(WellFormed(Row{short_head, {{second_byte}}}));
  std::swap(short_head.dlc, short_head.also_dlc);
  EXPECT_TRUE(WellFormed(Row{short_head, {{second_byte}}}));
  EXPECT_FALSE(with({"across bytes", "1", kField<&Msg::a>, 4, 8, Sign::kSigned, 1, 0, 1}));
  EXPECT_FALSE(with({"no bits", "1", kField<&Msg::a>, 0, 0, Sign::kSigned, 1, 0, 0}));
  EXPECT_FALSE(with({"33 bits", "1", kField<&Msg::a>, 0, 40, Sign::kSigned, 1, 0, 1}));
  EXPECT_FALSE(with({"scale", "1", kField<&Msg::a>, 0, 8, Sign::kSigned, 0, 0, 1}));
  EXPECT_FALSE(with({"min > max", "1", kField<&Msg::a>, 0, 8, Sign::kSigned, 1, 1, 0}));
  EXPECT_FALSE(with({"signed code", "1", kField<&Msg::c>, 0, 8, Sign::kSigned, 1, 0, 1}));
  const FrameSpec<Msg, 2> overlap{kHead,
                                  {{{"a", "1", kField<&Msg::a>, 0, 16, Sign::kSigned, 1, 0, 1},
                                    {"b", "1", kField<&Msg::b>, 8, 16, Sign::kSigned, 1, 0, 1}}}};
  EXPECT_FALSE(WellFormed(overlap));
  EXPECT_FALSE(WellFormed(std::tuple{kBaseState, kBaseState}));
}

TEST(Dispatch, CountsEachReasonOnItsOwn) {
  RxCounters n;
  int visits = 0;
  const auto visit = [&](const FrameHead&, const auto&, int) { ++visits; };
  const Frame good{.id = 0x211, .dlc = 8};
  const auto with = [&](auto change) {
    Frame frame = good;
    change(frame);
    return Dispatch(kTracerTable, frame, n, visit);
  };
  EXPECT_EQ(with([](Frame&) {}), Status::kOk);
  EXPECT_EQ(with([](Frame& f) { f.id = 0x7FF; }), Status::kMalformed);
  EXPECT_EQ(with([](Frame& f) { f.dlc = 7; }), Status::kMalformed);
  EXPECT_EQ(with([](Frame& f) { f.extended = true; }), Status::kMalformed);
  EXPECT_EQ(with([](Frame& f) { f.remote = true; }), Status::kMalformed);
  EXPECT_EQ(with([](Frame& f) { f.error = true; }), Status::kMalformed);
  EXPECT_EQ(with([](Frame& f) { f.data[0] = 9; }), Status::kOutOfRange);
  EXPECT_EQ(visits, 1);
  EXPECT_EQ(n.accepted, 1U);
  EXPECT_EQ(n.unknown_id, 1U);
  EXPECT_EQ(n.wrong_length, 1U);
  EXPECT_EQ(n.extended, 1U);
  EXPECT_EQ(n.remote, 1U);
  EXPECT_EQ(n.error_frame, 1U);
  EXPECT_EQ(n.out_of_range, 1U);
}

TEST(Dispatch, TakesAnyFrameWithoutHarmAndCountsEach) {
  Rng rng(7);
  RxCounters n;
  for (int i = 0; i < 200'000; ++i) {
    Frame frame{.id = static_cast<std::uint32_t>(rng.Index(0x800)),
                .dlc = static_cast<std::uint8_t>(rng.Index(9)),
                .extended = rng.Index(16) == 0,
                .remote = rng.Index(16) == 0,
                .error = rng.Index(16) == 0};
    for (std::uint8_t& byte : frame.data) {
      byte = static_cast<std::uint8_t>(rng.Index(256));
    }
    (void)Dispatch(kBothTables, frame, n, [](const FrameHead&, const auto&, int) {});
  }
  EXPECT_EQ(n.accepted + n.unknown_id + n.wrong_length + n.extended + n.remote + n.error_frame +
                n.out_of_range,
            200'000U);
  EXPECT_GT(n.accepted, 0U);
  EXPECT_GT(n.out_of_range, 0U);
}

TEST(Sdo, CommandBytesAreTheStandardsForEachLength) {
  constexpr std::uint32_t kDownload[] = {0x2F, 0x2B, 0x27, 0x23};
  constexpr std::uint32_t kUpload[] = {0x4F, 0x4B, 0x47, 0x43};
  for (int bytes = 1; bytes <= 4; ++bytes) {
    const Sdo down = DownloadRequest({0x1234, 5}, bytes, 0x01);
    const Sdo up = UploadResponse({0x1234, 5}, bytes, 0x01);
    EXPECT_EQ(down.command, kDownload[bytes - 1]);
    EXPECT_EQ(up.command, kUpload[bytes - 1]);
    EXPECT_EQ(Meaning(down, false).bytes, bytes);
    EXPECT_EQ(Meaning(up, true).kind, SdoKind::kUploadResponse);
  }
  EXPECT_EQ(Meaning({0x4B, 0x6041, 0, 0xFFFF0231}, true).value, 0x0231U);
  EXPECT_EQ(Meaning({0x80, 0x6060, 0, 0x06020000}, true).value,
            static_cast<std::uint32_t>(SdoAbort::kNoSuchObject));
  EXPECT_EQ(Meaning({0x41, 0x1008, 0, 20}, true).kind, SdoKind::kOther);  // segmented
  EXPECT_EQ(Meaning({0x22, 0x1008, 0, 20}, false).bytes, 4);              // no size given
}

TEST(DriveStates, EveryPatternWithItsFreeBitsSet) {
  struct Case {
    std::uint32_t mask;
    std::uint32_t value;
    DriveState state;
  };
  constexpr Case kCases[] = {
      {0x4F, 0x00, DriveState::kNotReady},         {0x4F, 0x40, DriveState::kSwitchOnDisabled},
      {0x6F, 0x21, DriveState::kReadyToSwitchOn},  {0x6F, 0x23, DriveState::kSwitchedOn},
      {0x6F, 0x27, DriveState::kOperationEnabled}, {0x6F, 0x07, DriveState::kQuickStopActive},
      {0x4F, 0x0F, DriveState::kFaultReaction},    {0x4F, 0x08, DriveState::kFault}};
  for (std::uint32_t word = 0; word <= 0xFFFF; ++word) {
    DriveState expected = DriveState::kUnknown;
    for (const Case& c : kCases) {
      if ((word & c.mask) == c.value) {
        expected = c.state;
      }
    }
    ASSERT_EQ(StateOf(word), expected) << word << " " << Name(expected);
  }
}

TEST(Docs, NameEveryFrameAndSignal) {
  std::array<char, kTableTextBytes> buffer{};
  const Result<int> length = DescribeTables(buffer);
  ASSERT_TRUE(length.ok());
  const std::string text(buffer.data(), static_cast<std::size_t>(*length));
  ForEachSignal([&](const auto& row, const auto& s, int) {
    EXPECT_NE(text.find(row.head.name), std::string::npos);
    EXPECT_NE(text.find(s.name), std::string::npos);
  });
  EXPECT_EQ(DescribeTables(std::span(buffer).first(100)).status(), Status::kFull);
}

}  // namespace
}  // namespace pipewright::can
