// SPDX-License-Identifier: MIT
#include "platform/linux/v4l2_depth.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <cstring>
#include <deque>
#include <memory>
#include <vector>

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""us;
using std::chrono_literals::operator""s;

constexpr CameraIntrinsics kCamera{
    .width = 4, .height = 3, .fx = 5, .fy = 5, .cx = 1.5, .cy = 1, .z_min_m = 0.1, .z_max_m = 6};

/// A device as the kernel's documentation has it; what it refuses can be chosen.
class FakeDevice final : public VideoCalls {
 public:
  int Open(const char*) override {
    if (open_error != 0) {
      errno = open_error;
      return -1;
    }
    ++opened;
    return 7;
  }
  void Close(int) override {
    --opened;
    queued.clear();
    streaming = false;
  }
  int Ioctl(int, unsigned long request, void* argument) override {
    if (request == refused) {
      errno = refused_error;
      return -1;
    }
    switch (request) {
      case VIDIOC_QUERYCAP: {
        auto* about = static_cast<v4l2_capability*>(argument);
        about->capabilities = V4L2_CAP_DEVICE_CAPS | V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
        about->device_caps = caps;
        return 0;
      }
      case VIDIOC_S_FMT: {
        v4l2_pix_format& pix = static_cast<v4l2_format*>(argument)->fmt.pix;
        EXPECT_EQ(pix.pixelformat, V4L2_PIX_FMT_Z16);
        pix.pixelformat = format;
        pix.width = width;
        pix.bytesperline = line_bytes;
        return 0;
      }
      case VIDIOC_REQBUFS:
        static_cast<v4l2_requestbuffers*>(argument)->count = buffers;
        return 0;
      case VIDIOC_QUERYBUF: {
        auto* buffer = static_cast<v4l2_buffer*>(argument);
        buffer->length = 64;
        buffer->m.offset = 64 * buffer->index;
        return 0;
      }
      case VIDIOC_QBUF:
        queued.push_back(static_cast<v4l2_buffer*>(argument)->index);
        return 0;
      case VIDIOC_DQBUF:
        return Dequeue(static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON:
        streaming = true;
        return 0;
      case VIDIOC_STREAMOFF:
        streaming = false;
        return 0;
      default:
        errno = ENOTTY;
        return -1;
    }
  }
  void* Map(int, std::size_t, std::int64_t offset) override {
    ++mapped;
    return memory + offset;
  }
  void Unmap(void*, std::size_t) override { --mapped; }

  /// A frame whose every pixel is `depth_mm`, padded at each line's end.
  void Fill(std::uint16_t depth_mm, std::uint32_t flags = 0, std::uint32_t bytes = 3 * 10) {
    waiting.push_back({depth_mm, flags, bytes});
  }

  int open_error = 0;
  unsigned long refused = 0;
  int refused_error = EINVAL;
  std::uint32_t caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::uint32_t format = V4L2_PIX_FMT_Z16;
  std::uint32_t width = 4;
  std::uint32_t line_bytes = 10;
  std::uint32_t buffers = 4;
  int opened = 0;
  int mapped = 0;
  bool streaming = false;
  std::deque<std::uint32_t> queued;

 private:
  struct Waiting {
    std::uint16_t depth_mm;
    std::uint32_t flags;
    std::uint32_t bytes;
  };

  int Dequeue(v4l2_buffer* buffer) {
    EXPECT_TRUE(streaming);
    if (waiting.empty() || queued.empty()) {
      errno = EAGAIN;
      return -1;
    }
    const Waiting frame = waiting.front();
    waiting.pop_front();
    buffer->index = queued.front();
    queued.pop_front();
    char* to = memory + 64 * buffer->index;
    std::memset(to, 0xEE, 64);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        std::memcpy(to + 10 * row + 2 * column, &frame.depth_mm, 2);
      }
    }
    buffer->flags = frame.flags;
    buffer->bytesused = frame.bytes;
    buffer->sequence = ++sequence;
    buffer->timestamp = {.tv_sec = 12, .tv_usec = 345'678};
    return 0;
  }

  std::deque<Waiting> waiting;
  std::uint32_t sequence = 0;
  char memory[4 * 64];
};

class V4l2DepthTest : public testing::Test {
 protected:
  Status Poll() { return camera_->Poll(now_, *frame_); }

  FakeDevice device_;
  std::unique_ptr<V4l2Depth> camera_ =
      std::make_unique<V4l2Depth>("/dev/video9", kCamera, -5ms, device_);
  std::unique_ptr<DepthFrame> frame_ = std::make_unique<DepthFrame>();
  Time now_{1s};
};

TEST_F(V4l2DepthTest, GivesTheNewestFrameWithoutThePaddingAndReturnsEveryBuffer) {
  EXPECT_EQ(Poll(), Status::kTimeout);
  EXPECT_EQ(device_.queued.size(), 4U);
  device_.Fill(100);
  device_.Fill(1234);
  ASSERT_EQ(Poll(), Status::kOk);
  EXPECT_EQ(frame_->stamp, Time{12'340'678us});
  EXPECT_EQ(frame_->sequence, 2U);
  EXPECT_EQ(frame_->camera.width, 4);
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(frame_->depth_mm[i], 1234) << i;
  }
  EXPECT_EQ(frame_->depth_mm[12], 0);
  EXPECT_EQ(device_.queued.size(), 4U);
  EXPECT_EQ(Poll(), Status::kTimeout);
}

TEST_F(V4l2DepthTest, PassesOverWhatCameDamaged) {
  device_.Fill(1, V4L2_BUF_FLAG_ERROR);
  device_.Fill(2, 0, 27);  // the last row lacks a byte
  EXPECT_EQ(Poll(), Status::kTimeout);
  EXPECT_EQ(camera_->damaged(), 2U);
  device_.Fill(3, 0, 28);  // the last row's padding alone
  EXPECT_EQ(Poll(), Status::kOk);
}

TEST_F(V4l2DepthTest, SaysWhatIsWrongWithADeviceAndLeavesItClosed) {
  const struct {
    const char* error;
    void (*make)(FakeDevice&);
  } cases[] = {
      {"cannot be opened: No such file", [](FakeDevice& d) { d.open_error = ENOENT; }},
      {"not ours to open (group video): Perm", [](FakeDevice& d) { d.open_error = EACCES; }},
      {"not a video device: Inapp",
       [](FakeDevice& d) {
         d.refused = VIDIOC_QUERYCAP;
         d.refused_error = ENOTTY;
       }},
      {"not a camera that streams", [](FakeDevice& d) { d.caps = V4L2_CAP_META_CAPTURE; }},
      {"refuses the format: Invalid", [](FakeDevice& d) { d.refused = VIDIOC_S_FMT; }},
      {"does not give depth (Z16)", [](FakeDevice& d) { d.format = V4L2_PIX_FMT_YUYV; }},
      {"gives 8x3, not the 4x3 asked for", [](FakeDevice& d) { d.width = 8; }},
      {"another process has the camera",
       [](FakeDevice& d) {
         d.refused = VIDIOC_REQBUFS;
         d.refused_error = EBUSY;
       }},
      {"gives too few buffers", [](FakeDevice& d) { d.buffers = 1; }},
      {"does not tell of its buffers", [](FakeDevice& d) { d.refused = VIDIOC_QUERYBUF; }},
      {"does not take its buffers", [](FakeDevice& d) { d.refused = VIDIOC_QBUF; }},
      {"does not stream", [](FakeDevice& d) { d.refused = VIDIOC_STREAMON; }},
  };
  for (const auto& c : cases) {
    FakeDevice device;
    c.make(device);
    V4l2Depth camera("/dev/video9", kCamera, {}, device);
    EXPECT_EQ(camera.Poll(now_, *frame_), Status::kUnavailable) << c.error;
    EXPECT_EQ(camera.error_text().find(std::string("/dev/video9: ") + c.error), 0U)
        << camera.error_text();
    EXPECT_EQ(device.opened, 0) << c.error;
    EXPECT_EQ(device.mapped, 0) << c.error;
  }
}

TEST_F(V4l2DepthTest, ADeviceThatGoesIsLookedForAgain) {
  EXPECT_EQ(Poll(), Status::kTimeout);
  device_.refused = VIDIOC_DQBUF;
  device_.refused_error = ENODEV;
  EXPECT_EQ(Poll(), Status::kUnavailable);
  EXPECT_EQ(device_.opened, 0);
  EXPECT_EQ(device_.mapped, 0);
  device_.refused = 0;
  now_ += 999ms;
  EXPECT_EQ(Poll(), Status::kUnavailable);
  now_ += 1ms;
  EXPECT_EQ(Poll(), Status::kTimeout);
  device_.Fill(9);
  EXPECT_EQ(Poll(), Status::kOk);
}

TEST(V4l2Depth, RealFilesThatAreNoCameraAreTold) {
  const auto frame = std::make_unique<DepthFrame>();
  V4l2Depth none("/dev/nosuchvideo", kCamera, {});
  EXPECT_EQ(none.Poll(Time{1s}, *frame), Status::kUnavailable);
  EXPECT_EQ(none.error_text(), "/dev/nosuchvideo: cannot be opened: No such file or directory");
  V4l2Depth null("/dev/null", kCamera, {});
  EXPECT_EQ(null.Poll(Time{1s}, *frame), Status::kUnavailable);
  EXPECT_EQ(null.error_text().find("/dev/null: not a video device"), 0U) << null.error_text();
}

}  // namespace
}  // namespace pipewright
