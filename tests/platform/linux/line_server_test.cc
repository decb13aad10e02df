// SPDX-License-Identifier: MIT
#include "platform/linux/line_server.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <deque>
#include <string>

#include "platform/core/rng.h"

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

class Client {
 public:
  explicit Client(const std::string& path) : socket_(socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    connected_ = connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~Client() { close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  bool connected() const { return connected_; }
  bool Send(const std::string& bytes) {
    return send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT) ==
           static_cast<ssize_t>(bytes.size());
  }
  /// What has come; "gone" when the server has hung up.
  std::string Receive() {
    char bytes[4096];
    const ssize_t size = recv(socket_, bytes, sizeof bytes, MSG_DONTWAIT);
    return size > 0 ? std::string(bytes, static_cast<std::size_t>(size)) : size == 0 ? "gone" : "";
  }

 private:
  int socket_;
  bool connected_ = false;
};

class LineServerTest : public testing::Test {
 protected:
  LineServerTest() { EXPECT_EQ(server_.Open(path_), Status::kOk) << server_.error_text(); }

  void Poll() {
    server_.Poll(now_, [this](std::string_view line, const Peer& peer, std::span<char> out) {
      lines_.emplace_back(line);
      peer_ = peer;
      std::string answer = "<";
      answer.append(line).append(">");
      return answer.copy(out.data(), out.size());
    });
  }

  const std::string path_ = testing::TempDir() + "pipewright_lines" + std::to_string(getpid());
  LineServer server_;
  Time now_{};
  std::vector<std::string> lines_;
  Peer peer_;
};

TEST_F(LineServerTest, AnswersEachLineWithOneAndKnowsWhoAsked) {
  Client client(path_);
  ASSERT_TRUE(client.Send("status\nsta"));
  Poll();
  EXPECT_EQ(client.Receive(), "<status>\n");
  Poll();
  EXPECT_EQ(client.Receive(), "");
  ASSERT_TRUE(client.Send("rt\na\nb\n"));
  for (int i = 0; i < 4; ++i) {
    Poll();
  }
  EXPECT_EQ(client.Receive(), "<start>\n<a>\n<b>\n");
  EXPECT_EQ(peer_.pid, getpid());
  EXPECT_EQ(peer_.uid, getuid());
  EXPECT_EQ(peer_.gid, getgid());
}

TEST_F(LineServerTest, IsOpenToOwnerAndGroupAlone) {
  struct stat about {};
  ASSERT_EQ(stat(path_.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 07777U, 0660U);
}

TEST_F(LineServerTest, APollServesEachClientOneLine) {
  Client eager(path_);
  Client other(path_);
  ASSERT_TRUE(eager.Send("1\n2\n3\n"));
  ASSERT_TRUE(other.Send("x\n"));
  Poll();
  EXPECT_EQ(lines_.size(), 2U);
  EXPECT_EQ(eager.Receive(), "<1>\n");
  EXPECT_EQ(other.Receive(), "<x>\n");
}

TEST_F(LineServerTest, ARequestWithoutEndIsRefused) {
  Client client(path_);
  ASSERT_TRUE(client.Send(std::string(10'000, 'x')));
  Poll();
  EXPECT_NE(client.Receive().find("too long"), std::string::npos);
  EXPECT_EQ(server_.clients(), 0);
  EXPECT_EQ(server_.refused(), 1U);
  EXPECT_TRUE(lines_.empty());
}

TEST_F(LineServerTest, MoreClientsThanThereIsRoomForAreToldSo) {
  std::deque<Client> clients;
  for (int i = 0; i < LineServer::kClients + 1; ++i) {
    clients.emplace_back(path_);
    Poll();
  }
  EXPECT_NE(clients.back().Receive().find("too many clients"), std::string::npos);
  EXPECT_EQ(server_.clients(), LineServer::kClients);
  ASSERT_TRUE(clients.front().Send("status\n"));
  Poll();
  EXPECT_EQ(clients.front().Receive(), "<status>\n");  // the others have theirs
}

TEST_F(LineServerTest, WhoSaysNothingLosesItsPlace) {
  Client client(path_);
  Poll();
  now_ += LineServer::kPatience;
  Poll();
  EXPECT_EQ(server_.clients(), 1);
  now_ += 1ms;
  Poll();
  EXPECT_EQ(server_.clients(), 0);
  EXPECT_NE(client.Receive().find("no request came"), std::string::npos);
}

TEST_F(LineServerTest, WhoDoesNotReadIsSentAway) {
  Client client(path_);
  for (int i = 0; i < 200'000 && server_.refused() == 0; ++i) {
    client.Send("status\n");
    Poll();
  }
  EXPECT_EQ(server_.refused(), 1U);
  EXPECT_EQ(server_.clients(), 0);
}

TEST_F(LineServerTest, GarbageIsALineLikeAnyOther) {
  Rng rng(3);
  for (int round = 0; round < 200; ++round) {
    Client client(path_);
    std::string bytes;
    for (int i = 0; i < 100; ++i) {
      bytes += static_cast<char>(rng.Index(256));
    }
    ASSERT_TRUE(client.Send(bytes));
    for (int i = 0; i < 4; ++i) {
      Poll();
    }
  }
  Client client(path_);
  ASSERT_TRUE(client.Send("status\n"));
  Poll();
  EXPECT_EQ(client.Receive(), "<status>\n");
}

TEST_F(LineServerTest, APathInUseIsRefusedAndOneLeftBehindIsTakenOver) {
  LineServer second;
  EXPECT_EQ(second.Open(path_), Status::kUnavailable);
  EXPECT_NE(second.error_text().find("another process answers there"), std::string::npos);
  Client client(path_);
  EXPECT_TRUE(client.connected());  // the first one is as it was

  const std::string left = path_ + "_left";
  unlink(left.c_str());
  const int dead = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  left.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(bind(dead, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  close(dead);
  EXPECT_EQ(second.Open(left), Status::kOk) << second.error_text();
  second.Close();
  EXPECT_NE(access(left.c_str(), F_OK), 0);  // and removed in the end
}

TEST_F(LineServerTest, AFileThatIsNoSocketIsLeftAlone) {
  const std::string file = path_ + "_file";
  FILE* out = std::fopen(file.c_str(), "w");
  std::fclose(out);
  LineServer second;
  EXPECT_EQ(second.Open(file), Status::kUnavailable);
  EXPECT_NE(second.error_text().find("not a socket"), std::string::npos);
  EXPECT_EQ(access(file.c_str(), F_OK), 0);
  unlink(file.c_str());
  EXPECT_EQ(second.Open(std::string(200, 'x')), Status::kUnavailable);
  EXPECT_EQ(second.Open("/nowhere/s.sock"), Status::kUnavailable);
}

}  // namespace
}  // namespace pipewright
