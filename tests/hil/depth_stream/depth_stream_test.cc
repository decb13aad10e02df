// SPDX-License-Identifier: MIT
// The two ends of a depth stream, over a socket in the test's own folder.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <thread>

#include "hil/depth_stream/depth_sender.h"
#include "platform/linux/clock.h"
#include "platform/linux/depth_socket.h"

namespace pipewright::hil {
namespace {

using std::chrono_literals::operator""s;

class DepthStream : public testing::Test {
 protected:
  DepthStream() : frame_(std::make_unique<DepthFrame>()), heard_(std::make_unique<DepthFrame>()) {
    frame_->camera = {848, 480, 400, 400, 423.5, 239.5, 0.2, 6};
    path_ = std::filesystem::temp_directory_path() / ("pw_depth_" + std::to_string(getpid()));
    std::filesystem::remove(path_);
  }
  ~DepthStream() override { std::filesystem::remove(path_); }

  using Reader = std::unique_ptr<DepthSocket>;

  /// A reader that is connected.
  Reader Connect() {
    auto reader = std::make_unique<DepthSocket>(path_);
    EXPECT_EQ(reader->Poll(Now(), *heard_), Status::kTimeout) << reader->error_text();
    return reader;
  }

  /// The next frame, or why there is none within 10 s.
  Status Read(DepthSocket& reader) {
    const Time until = Now() + 10s;
    Status status = Status::kTimeout;
    while (status == Status::kTimeout && Now() < until) {
      status = reader.Poll(Now(), *heard_);
    }
    return status;
  }

  /// Sends from a thread of its own: a frame is larger than a socket's room.
  Status Pass(DepthSocket& reader) {
    ++frame_->sequence;
    frame_->depth_mm[1] = static_cast<std::uint16_t>(frame_->sequence);
    std::thread sending([this] { sender_.Send(*frame_); });
    const Status status = Read(reader);
    sending.join();
    return status;
  }

  std::filesystem::path path_;
  DepthSender sender_;
  std::unique_ptr<DepthFrame> frame_;
  std::unique_ptr<DepthFrame> heard_;
};

TEST_F(DepthStream, AReaderGetsTheFramesSentSinceItCame) {
  ASSERT_EQ(sender_.Open(path_), "");
  sender_.Send(*frame_);  // to nobody
  const Reader reader = Connect();
  for (std::uint32_t i = 1; i <= 3; ++i) {
    ASSERT_EQ(Pass(*reader), Status::kOk);
    EXPECT_EQ(heard_->sequence, i);
    EXPECT_EQ(heard_->depth_mm[1], i);
  }
  EXPECT_EQ(reader->Poll(Now(), *heard_), Status::kTimeout);
  EXPECT_EQ(sender_.readers_seen(), 1U);
  EXPECT_EQ(sender_.readers_lost(), 0U);
}

TEST_F(DepthStream, AReaderThatHasLeftOrDoesNotReadIsSentAway) {
  ASSERT_EQ(sender_.Open(path_), "");
  const Reader reads = Connect();
  Reader leaves = Connect();
  ASSERT_TRUE(sender_.HasReaders());
  leaves.reset();
  const Reader sleeps = Connect();
  EXPECT_EQ(Pass(*reads), Status::kOk);
  EXPECT_EQ(Pass(*reads), Status::kOk);
  EXPECT_EQ(sender_.readers_seen(), 3U);
  EXPECT_EQ(sender_.readers_lost(), 2U);
}

TEST_F(DepthStream, TheReaderIsToldOfTheEndAndComesBack) {
  ASSERT_EQ(sender_.Open(path_), "");
  const Reader reader = Connect();
  ASSERT_TRUE(sender_.HasReaders());
  sender_.Close();
  EXPECT_FALSE(std::filesystem::exists(path_));
  EXPECT_EQ(Read(*reader), Status::kUnavailable);
  ASSERT_EQ(sender_.Open(path_), "");
  SleepUntil(Now() + DepthSocket::kRetry);
  EXPECT_EQ(reader->Poll(Now(), *heard_), Status::kTimeout) << reader->error_text();
  EXPECT_EQ(Pass(*reader), Status::kOk);
}

TEST_F(DepthStream, APathInUseOrImpossibleIsRefusedAndOneLeftBehindTakenOver) {
  ASSERT_EQ(sender_.Open(path_), "");
  DepthSender second;
  EXPECT_NE(second.Open(path_).find("another process"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(path_)) << "the first one's";
  sender_.Close();

  {  // as a process leaves it that was killed
    sockaddr_un address{};
    ASSERT_EQ(LocalAddress(path_, address), "");
    const Descriptor dead(socket(AF_UNIX, SOCK_STREAM, 0));
    ASSERT_EQ(bind(dead.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ASSERT_TRUE(std::filesystem::exists(path_));
  EXPECT_EQ(second.Open(path_), "");
  second.Close();

  std::ofstream(path_) << "somebody's file";
  EXPECT_NE(second.Open(path_), "");
  EXPECT_TRUE(std::filesystem::is_regular_file(path_));
  EXPECT_NE(second.Open(std::string(200, 'x')).find("107"), std::string::npos);
  EXPECT_NE(second.Open("/nosuchfolder/depth"), "");
}

}  // namespace
}  // namespace pipewright::hil
