// SPDX-License-Identifier: MIT
#include "platform/linux/notify.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

/// systemd's end: a datagram socket at a path.
class Manager {
 public:
  explicit Manager(std::string path) : path_(std::move(path)) {
    unlink(path_.c_str());
    socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.copy(address.sun_path, sizeof address.sun_path - 1);
    std::size_t size = offsetof(sockaddr_un, sun_path) + path_.size();
    if (path_.front() == '@') {
      address.sun_path[0] = '\0';
    }
    EXPECT_EQ(
        bind(socket_, reinterpret_cast<const sockaddr*>(&address), static_cast<socklen_t>(size)),
        0);
  }
  ~Manager() {
    close(socket_);
    unlink(path_.c_str());
  }
  std::string Heard() {
    char bytes[512];
    const ssize_t size = recv(socket_, bytes, sizeof bytes, 0);
    return size < 0 ? "" : std::string(bytes, static_cast<std::size_t>(size));
  }

 private:
  std::string path_;
  int socket_ = -1;
};

std::string Path(const char* name) {
  return testing::TempDir() + "pipewright_" + name + std::to_string(getpid());
}

TEST(ServiceNotify, SendsEachWordAsOneDatagram) {
  for (const std::string& path : {Path("notify"), "@pipewright_" + std::to_string(getpid())}) {
    Manager manager(path);
    const ServiceNotify notify(path, 2s);
    ASSERT_TRUE(notify.active()) << path;
    EXPECT_EQ(notify.Send("READY=1\nSTATUS=idle"), Status::kOk);
    EXPECT_EQ(notify.Send("WATCHDOG=1"), Status::kOk);
    EXPECT_EQ(manager.Heard(), "READY=1\nSTATUS=idle");
    EXPECT_EQ(manager.Heard(), "WATCHDOG=1");
    EXPECT_EQ(manager.Heard(), "");
  }
}

TEST(ServiceNotify, NobodyListeningIsAnAnswer) {
  const ServiceNotify nobody;
  EXPECT_FALSE(nobody.active());
  EXPECT_EQ(nobody.Send("READY=1"), Status::kUnavailable);
  EXPECT_EQ(ServiceNotify(Path("nowhere"), {}).Send("READY=1"), Status::kUnavailable);
  EXPECT_EQ(ServiceNotify(std::string(200, 'x'), {}).Send("READY=1"), Status::kUnavailable);
}

TEST(ServiceNotify, NeverWaitsForAManagerThatDoesNotRead) {
  Manager manager(Path("full"));
  const ServiceNotify notify(Path("full"), 1s);
  int sent = 0;
  while (sent < 100'000 && notify.Send("WATCHDOG=1") == Status::kOk) {
    ++sent;
  }
  EXPECT_LT(sent, 100'000);  // the queue is full, and that was an answer
}

TEST(ServiceNotify, TakesTheWatchdogOfTheEnvironmentIfItIsThisProcesss) {
  const struct {
    const char* usec;
    std::string pid;
    Duration watchdog;
  } cases[] = {
      {"4000000", std::to_string(getpid()), 4s},
      {"4000000", "", 4s},
      {"4000000", "1", 0s},
      {"-4", "", 0s},
      {"4x", "", 0s},
      {"", "", 0s},
  };
  for (const auto& c : cases) {
    setenv("WATCHDOG_USEC", c.usec, 1);
    setenv("WATCHDOG_PID", c.pid.c_str(), 1);
    EXPECT_EQ(ServiceNotify::OfEnvironment().watchdog(), c.watchdog) << c.usec << " " << c.pid;
  }
  unsetenv("WATCHDOG_USEC");
  unsetenv("WATCHDOG_PID");
  EXPECT_EQ(ServiceNotify::OfEnvironment().watchdog(), Duration::zero());
}

}  // namespace
}  // namespace pipewright
