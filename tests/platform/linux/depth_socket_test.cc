// SPDX-License-Identifier: MIT
#include "platform/linux/depth_socket.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <memory>
#include <vector>

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

/// A camera's end.
class Sender {
 public:
  explicit Sender(const std::string& path) : path_(path) {
    unlink(path.c_str());
    listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(listen(listener_, 1), 0);
  }
  ~Sender() {
    Leave();
    close(listener_);
    unlink(path_.c_str());
  }
  void Accept() {
    reader_ = accept(listener_, nullptr, nullptr);
    ASSERT_GE(reader_, 0);
  }
  void Leave() {
    if (reader_ >= 0) {
      close(reader_);
    }
    reader_ = -1;
  }
  void Send(std::span<const std::uint8_t> bytes) {
    ASSERT_EQ(send(reader_, bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }

 private:
  std::string path_;
  int listener_ = -1;
  int reader_ = -1;
};

class DepthSocketTest : public testing::Test {
 protected:
  DepthSocketTest() {
    sent_->stamp = Time{Duration{-123'456'789'012}};
    sent_->sequence = 0xFEDCBA98;
    sent_->camera = {.width = 5,
                     .height = 3,
                     .fx = 1.5,
                     .fy = 2.5,
                     .cx = 2,
                     .cy = 1,
                     .z_min_m = 0.1,
                     .z_max_m = 6};
    for (int i = 0; i < 15; ++i) {
      sent_->depth_mm[i] = static_cast<std::uint16_t>(1000 * i + 7);
    }
    bytes_.resize(200);
    bytes_.resize(PutDepthFrame(*sent_, bytes_));
  }
  void Connect() {
    ASSERT_EQ(camera_->Poll(now_, *frame_), Status::kTimeout) << camera_->error_text();
    sender_.Accept();
  }

  const std::string path_ = testing::TempDir() + "pipewright_depth" + std::to_string(getpid());
  Sender sender_{path_};
  std::unique_ptr<DepthSocket> camera_ = std::make_unique<DepthSocket>(path_);
  std::unique_ptr<DepthFrame> sent_ = std::make_unique<DepthFrame>();
  std::unique_ptr<DepthFrame> frame_ = std::make_unique<DepthFrame>();
  std::vector<std::uint8_t> bytes_;
  Time now_{1s};
};

TEST_F(DepthSocketTest, TheWireIsAsItIsWrittenDown) {
  ASSERT_EQ(bytes_.size(), 72U + 30U);
  const std::vector<std::uint8_t> head = {'P', 'W', 'Z', '1', 0x98, 0xBA, 0xDC, 0xFE};
  EXPECT_TRUE(std::equal(head.begin(), head.end(), bytes_.begin()));
  EXPECT_EQ(bytes_[16], 5);
  EXPECT_EQ(bytes_[20], 3);
  // 1.5 in IEEE 754: 3FF8 0000 0000 0000
  EXPECT_EQ(bytes_[24 + 7], 0x3F);
  EXPECT_EQ(bytes_[24 + 6], 0xF8);
  EXPECT_EQ(bytes_[72 + 2], (1007 & 0xFF));
  EXPECT_EQ(bytes_[72 + 3], 1007 >> 8);
  std::vector<std::uint8_t> small(101);
  EXPECT_EQ(PutDepthFrame(*sent_, small), 0U);
}

TEST_F(DepthSocketTest, GivesAFrameHoweverItsBytesCome) {
  Connect();
  for (const std::uint8_t& byte : bytes_) {
    EXPECT_EQ(camera_->Poll(now_, *frame_), Status::kTimeout);
    sender_.Send({&byte, 1});
  }
  ASSERT_EQ(camera_->Poll(now_, *frame_), Status::kOk);
  EXPECT_EQ(frame_->stamp, sent_->stamp);
  EXPECT_EQ(frame_->sequence, sent_->sequence);
  EXPECT_EQ(frame_->camera.width, 5);
  EXPECT_EQ(frame_->camera.z_max_m, 6);
  EXPECT_EQ(frame_->depth_mm, sent_->depth_mm);
  std::vector<std::uint8_t> two = bytes_;
  two.insert(two.end(), bytes_.begin(), bytes_.end());
  sender_.Send(two);
  EXPECT_EQ(camera_->Poll(now_, *frame_), Status::kOk);
  EXPECT_EQ(camera_->Poll(now_, *frame_), Status::kOk);
  EXPECT_EQ(camera_->Poll(now_, *frame_), Status::kTimeout);
}

TEST_F(DepthSocketTest, ComesBackAfterTheSenderHasLeft) {
  Connect();
  sender_.Send(std::span(bytes_).first(50));
  EXPECT_EQ(camera_->Poll(now_, *frame_), Status::kTimeout);
  sender_.Leave();
  EXPECT_EQ(camera_->Poll(now_, *frame_), Status::kUnavailable);
  EXPECT_NE(camera_->error_text().find("the sender has left"), std::string::npos);
  EXPECT_EQ(camera_->Poll(now_ + 999ms, *frame_), Status::kUnavailable);  // not at once
  now_ += DepthSocket::kRetry;
  Connect();
  sender_.Send(bytes_);
  EXPECT_EQ(camera_->Poll(now_, *frame_), Status::kOk);  // the piece from before is forgotten
}

TEST_F(DepthSocketTest, WhatIsNoFrameEndsTheConnection) {
  for (const std::size_t at : {0U, 16U + 2U, 24U + 7U}) {  // name, width, fx
    std::vector<std::uint8_t> bad = bytes_;
    bad[at] ^= 0x80;
    now_ += DepthSocket::kRetry;
    Connect();
    sender_.Send(bad);
    EXPECT_EQ(camera_->Poll(now_, *frame_), Status::kUnavailable) << at;
    EXPECT_NE(camera_->error_text().find("no depth frame"), std::string::npos) << at;
    sender_.Leave();
  }
}

TEST(DepthSocket, ASocketThatIsNotThereIsNamed) {
  const auto camera = std::make_unique<DepthSocket>("/nowhere/depth.sock");
  const auto frame = std::make_unique<DepthFrame>();
  EXPECT_EQ(camera->Poll(Time{1s}, *frame), Status::kUnavailable);
  EXPECT_EQ(camera->error_text(), "/nowhere/depth.sock: No such file or directory");
}

}  // namespace
}  // namespace pipewright
