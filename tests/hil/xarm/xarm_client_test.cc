// SPDX-License-Identifier: MIT
#include "hil/xarm/xarm_client.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <random>
#include <vector>

#include "hil/xarm/wire_bytes.h"

namespace pipewright::hil {
namespace {

using std::chrono::milliseconds;
using Bytes = std::vector<std::uint8_t>;

/// A client, and the far ends of its two connections in the test's hand.
struct Desk {
  Desk() {
    EXPECT_EQ(requests.Open("127.0.0.1", 0), "");
    EXPECT_EQ(reports.Open("127.0.0.1", 0), "");
    config.address = "127.0.0.1";
    config.request_port = requests.port();
    config.report_port = reports.port();
    client = XarmClient(config);
  }
  /// Time stands while the kernel works.
  template <typename Condition>
  bool Until(const Condition& holds) {
    for (int i = 0; i < 50000 && !holds(); ++i) {
      client.Step(now);
      far_requests.Poll();
      usleep(100);
    }
    return holds();
  }
  void Connect() {
    client.Connect(now);
    ASSERT_TRUE(Until([&] { return client.up(); }));
    ASSERT_TRUE(Until([&] {
      if (!far_requests.open()) {
        far_requests = TcpStream(requests.Accept());
      }
      if (!far_reports.open()) {
        far_reports = TcpStream(reports.Accept());
      }
      return far_requests.open() && far_reports.open();
    }));
  }
  void Ask(XarmRegister reg) { ASSERT_EQ(client.Ask(XarmAsk(reg), now), Status::kOk); }
  /// The next request that came.
  XarmFrame Heard() {
    Result<std::size_t> size = std::size_t{0};
    EXPECT_TRUE(Until([&] {
      size = XarmFrameBytes(far_requests.received());
      return size.ok() && *size > 0 && *size <= far_requests.received().size();
    }));
    const Result<XarmFrame> frame = DecodeXarmFrame(far_requests.received().first(*size));
    far_requests.Take(*size);
    EXPECT_TRUE(frame.ok());
    return *frame;
  }
  void Say(const XarmFrame& answer) {
    std::array<std::uint8_t, XarmFrame::kBytesMax> room{};
    ASSERT_TRUE(far_requests.Send({room.data(), EncodeXarmFrame(answer, room)}));
  }
  void Settle() {
    EXPECT_TRUE(Until([&] {
      return client.requests().arrived() == far_requests.sent() &&
             client.reports().arrived() == far_reports.sent();
    }));
    client.Step(now);
  }

  TcpListener requests;
  TcpListener reports;
  XarmClientConfig config;
  XarmClient client{config};
  TcpStream far_requests;
  TcpStream far_reports;
  Time now{std::chrono::seconds(10)};
};

TEST(XarmClient, NumbersItsRequestsAndMatchesTheirAnswersInAnyOrder) {
  Desk desk;
  desk.Connect();
  desk.Ask(XarmRegister::kGetState);
  desk.Ask(XarmRegister::kGetError);
  const XarmFrame first = desk.Heard();
  const XarmFrame second = desk.Heard();
  EXPECT_EQ(second.transaction, first.transaction + 1);
  EXPECT_EQ(desk.client.unanswered(), 2);
  const std::uint8_t no_error[] = {5, 6};
  desk.Say(XarmResponse(second, 0, no_error));
  desk.Say(XarmResponse(first, 0));
  desk.Settle();
  XarmFrame answer;
  ASSERT_TRUE(desk.client.TakeAnswer(answer));
  EXPECT_EQ(answer.reg(), XarmRegister::kGetError);
  EXPECT_EQ(DecodeXarmErrors(answer)->warning, 6);
  ASSERT_TRUE(desk.client.TakeAnswer(answer));
  EXPECT_EQ(answer.reg(), XarmRegister::kGetState);
  EXPECT_FALSE(desk.client.TakeAnswer(answer));
  EXPECT_EQ(desk.client.unanswered(), 0);
  EXPECT_EQ(desk.client.strays(), 0U);
}

TEST(XarmClient, DropsWhatNobodyWaitsFor) {
  Desk desk;
  desk.Connect();
  desk.Ask(XarmRegister::kGetState);
  const XarmFrame request = desk.Heard();
  XarmFrame other = XarmResponse(request, 0);
  other.transaction = static_cast<std::uint16_t>(other.transaction + 1);
  desk.Say(other);
  other = XarmResponse(request, 0);
  other.register_number = 15;
  desk.Say(other);
  other = XarmResponse(request, 0);
  other.size = 0;  // without its state
  desk.Say(other);
  const std::uint8_t heartbeat[] = {0, 0, 0, 1, 0, 2, 0, 0};  // of the vendor's client
  ASSERT_TRUE(desk.far_requests.Send(heartbeat));
  desk.Settle();
  XarmFrame answer;
  EXPECT_FALSE(desk.client.TakeAnswer(answer));
  EXPECT_EQ(desk.client.strays(), 4U);
  desk.Say(XarmResponse(request, 0));
  desk.Say(XarmResponse(request, 0));  // once more: nobody waits any longer
  desk.Settle();
  EXPECT_TRUE(desk.client.TakeAnswer(answer));
  EXPECT_FALSE(desk.client.TakeAnswer(answer));
  EXPECT_EQ(desk.client.strays(), 5U);
}

TEST(XarmClient, AnAnswerThatStaysAwayEndsIt) {
  Desk desk;
  desk.Connect();
  desk.Ask(XarmRegister::kGetState);
  desk.now += desk.config.answer_timeout;
  desk.client.Step(desk.now);
  EXPECT_TRUE(desk.client.up());
  desk.now += milliseconds(1);
  desk.client.Step(desk.now);
  EXPECT_EQ(desk.client.problem(), XarmProblem::kNoAnswer);
  EXPECT_FALSE(desk.client.up());
  EXPECT_EQ(desk.client.Ask(XarmAsk(XarmRegister::kGetState), desk.now), Status::kUnavailable);
}

TEST(XarmClient, HasOnlySoManyRequestsUnderWay) {
  Desk desk;
  desk.Connect();
  for (int i = 0; i < XarmClient::kUnderWay; ++i) {
    desk.Ask(XarmRegister::kGetState);
  }
  EXPECT_EQ(desk.client.Ask(XarmAsk(XarmRegister::kGetState), desk.now), Status::kFull);
  EXPECT_TRUE(desk.client.up());
}

TEST(XarmClient, AConnectionThatEndsIsToldAndNotMended) {
  Desk desk;
  desk.Connect();
  desk.far_reports.Close();
  EXPECT_TRUE(desk.Until([&] { return desk.client.problem() == XarmProblem::kClosed; }));
  for (int i = 0; i < 100; ++i) {
    desk.client.Step(desk.now += milliseconds(100));
  }
  EXPECT_EQ(desk.client.problem(), XarmProblem::kClosed);
  EXPECT_FALSE(desk.client.connecting());
  desk.far_requests = TcpStream();
  desk.Connect();
  EXPECT_EQ(desk.client.problem(), XarmProblem::kNone);
}

TEST(XarmClient, NobodyThereIsUnreachable) {
  Desk desk;
  desk.reports = TcpListener();
  desk.client.Connect(desk.now);
  EXPECT_TRUE(desk.Until([&] { return desk.client.problem() != XarmProblem::kNone; }));
  EXPECT_EQ(desk.client.problem(), XarmProblem::kUnreachable);
  // 192.0.2.0/24 belongs to nobody (RFC 5737): packets there are lost, or refused on the way.
  desk.config.address = "192.0.2.1";
  desk.client = XarmClient(desk.config);
  desk.client.Connect(desk.now);
  for (int i = 0; i < 20; ++i) {
    desk.client.Step(desk.now += milliseconds(100));
  }
  EXPECT_TRUE(desk.client.problem() == XarmProblem::kConnectTimeout ||
              desk.client.problem() == XarmProblem::kUnreachable);
}

TEST(XarmClient, KeepsTheLatestReportsAndRefusesWhatNoArmCanDo) {
  Desk desk;
  desk.Connect();
  std::array<std::uint8_t, kXarmReportBytesMax> room{};
  for (int i = 0; i < XarmClient::kReportsMax + 2; ++i) {
    XarmReport report{.queued = i};
    report.position_rad.setConstant(i == 5 ? 100.0 : 0.1);
    const std::size_t size = EncodeXarmReport(XarmReportKind::kReal, report, room);
    ASSERT_TRUE(desk.far_reports.Send({room.data(), size}));
  }
  desk.Settle();
  XarmReport report;
  std::vector<int> taken;
  while (desk.client.TakeReport(report)) {
    taken.push_back(report.queued);
  }
  EXPECT_EQ(taken, (std::vector{1, 2, 3, 4, 6, 7, 8, 9}));
  EXPECT_EQ(desk.client.bad_reports(), 1U);
}

TEST(XarmClient, BytesThatAreNoFrameEndIt) {
  for (const bool on_requests : {true, false}) {
    Desk desk;
    desk.Connect();
    const Bytes bytes(16, 0xFF);
    ASSERT_TRUE((on_requests ? desk.far_requests : desk.far_reports).Send(bytes));
    EXPECT_TRUE(desk.Until([&] { return desk.client.problem() != XarmProblem::kNone; }));
    EXPECT_EQ(desk.client.problem(), XarmProblem::kMalformed);
  }
}

// 200 seeds: noise of random length, some of it behind the head of a true frame, on both streams.
// Whatever comes, the client holds its bounds, and every report it gives is one that an arm can do.
TEST(XarmClient, NoNoiseMakesItGiveWhatIsNotThere) {
  int given = 0;
  int ended = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 rng(seed);
    Desk desk;
    desk.Connect();
    desk.Ask(XarmRegister::kGetState);
    for (int burst = 0; burst < 5 && desk.client.up(); ++burst) {
      Bytes noise(rng() % 300);
      for (std::uint8_t& byte : noise) {
        byte = static_cast<std::uint8_t>(rng());
      }
      const bool headed = rng() % 2 == 0;
      if (headed && noise.size() >= 87) {
        noise.resize(87);
        wire_bytes::PutInteger(noise, 0, 4, 87);
      }
      (void)desk.far_reports.Send(noise);
      if (headed && noise.size() >= 8) {
        wire_bytes::PutInteger(noise, 2, 2, 2);
        wire_bytes::PutInteger(noise, 4, 2, noise.size() - 6);
      }
      (void)desk.far_requests.Send(noise);
      desk.Until([&] {
        return !desk.client.up() || (desk.client.requests().arrived() == desk.far_requests.sent() &&
                                     desk.client.reports().arrived() == desk.far_reports.sent());
      });
      desk.client.Step(desk.now);
      XarmReport report;
      while (desk.client.TakeReport(report)) {
        ++given;
        EXPECT_TRUE((report.position_rad.array().abs() <= 7).all());
      }
      XarmFrame answer;
      while (desk.client.TakeAnswer(answer)) {
        EXPECT_EQ(answer.reg(), XarmRegister::kGetState);
      }
      EXPECT_LE(desk.client.unanswered(), 1);
    }
    ended += desk.client.problem() == XarmProblem::kMalformed ? 1 : 0;
    EXPECT_EQ(desk.client.up(), desk.client.problem() == XarmProblem::kNone);
  }
  EXPECT_GT(ended, 100) << "most noise is no frame";
  EXPECT_LT(given, 100) << "and hardly any is a report";
}

}  // namespace
}  // namespace pipewright::hil
