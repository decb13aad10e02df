// SPDX-License-Identifier: MIT
#include "hil/xarm/tcp_stream.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <vector>

namespace pipewright::hil {
namespace {

/// Polls until it holds, or for seconds: the kernel's pace is no matter.
template <typename Condition>
bool Until(TcpStream& stream, const Condition& holds) {
  for (int i = 0; i < 50000 && !holds(); ++i) {
    stream.Poll();
    usleep(100);
  }
  return holds();
}

struct Pair {
  Pair() {
    error = listener.Open("127.0.0.1", 0);
    connect = client.Connect("127.0.0.1", listener.port());
    Until(client, [this] { return client.open(); });
    for (int i = 0; i < 50000 && !server.open(); ++i) {
      server = TcpStream(listener.Accept());
      usleep(server.open() ? 0 : 100);
    }
  }
  TcpListener listener;
  TcpStream client;
  TcpStream server;
  std::string error;
  Status connect = Status::kOk;
};

TEST(TcpStream, CarriesBytesAndCountsThem) {
  Pair pair;
  ASSERT_EQ(pair.error, "");
  ASSERT_EQ(pair.connect, Status::kOk);
  ASSERT_TRUE(pair.client.open() && pair.server.open());
  const std::vector<std::uint8_t> bytes = {1, 2, 3, 4, 5};
  EXPECT_TRUE(pair.client.Send(bytes));
  EXPECT_TRUE(pair.client.Send(bytes));
  EXPECT_EQ(pair.client.sent(), 10U);
  ASSERT_TRUE(Until(pair.server, [&] { return pair.server.received().size() == 10; }));
  EXPECT_EQ(pair.server.arrived(), 10U);
  pair.server.Take(3);
  ASSERT_EQ(pair.server.received().size(), 7U);
  EXPECT_EQ(pair.server.received()[0], 4);
  EXPECT_EQ(pair.server.received()[2], 1);
  EXPECT_EQ(pair.server.arrived(), 10U);
}

TEST(TcpStream, HoldsWhatCameBeforeTheEnd) {
  Pair pair;
  const std::vector<std::uint8_t> bytes = {7, 8};
  ASSERT_TRUE(pair.server.Send(bytes));
  pair.server.Close();
  EXPECT_TRUE(Until(pair.client, [&] { return !pair.client.open(); }));
  EXPECT_EQ(pair.client.received().size(), 2U);
  EXPECT_FALSE(pair.client.Send(bytes));
}

TEST(TcpStream, TakesNoMoreThanItHasRoomForUntilSomeIsTaken) {
  Pair pair;
  const std::vector<std::uint8_t> bytes(TcpStream::kRoom + 100, 0x5A);
  ASSERT_TRUE(pair.client.Send(bytes));
  ASSERT_TRUE(
      Until(pair.server, [&] { return pair.server.received().size() == TcpStream::kRoom; }));
  pair.server.Poll();
  EXPECT_EQ(pair.server.received().size(), TcpStream::kRoom);
  pair.server.Take(TcpStream::kRoom);
  EXPECT_TRUE(Until(pair.server, [&] { return pair.server.received().size() == 100; }));
}

TEST(TcpStream, APeerThatDoesNotReadIsGivenUp) {
  Pair pair;
  const std::vector<std::uint8_t> bytes(1 << 16);
  int sent = 0;
  while (sent < 10000 && pair.client.Send(bytes)) {
    ++sent;
  }
  EXPECT_LT(sent, 10000) << "the kernel's queues have an end";
  EXPECT_FALSE(pair.client.open());
}

TEST(TcpStream, NoAddressAndNoListenerAreErrors) {
  TcpStream stream;
  EXPECT_EQ(stream.Connect("robot.local", 502), Status::kMalformed);
  EXPECT_FALSE(stream.open() || stream.connecting());
  TcpListener listener;
  ASSERT_EQ(listener.Open("127.0.0.1", 0), "");
  const int port = listener.port();
  EXPECT_NE(TcpListener().Open("127.0.0.1", port).find("in use"), std::string::npos);
  EXPECT_NE(TcpListener().Open("here", 0).find("not an IPv4 address"), std::string::npos);
  listener = TcpListener();  // now nobody listens there
  if (stream.Connect("127.0.0.1", port) == Status::kOk) {
    EXPECT_TRUE(Until(stream, [&] { return !stream.connecting(); }));
  }
  EXPECT_FALSE(stream.open());
}

}  // namespace
}  // namespace pipewright::hil
