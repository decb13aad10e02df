// SPDX-License-Identifier: MIT
#include "platform/linux/v4l2_depth.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace pipewright {
namespace {

constexpr std::uint32_t kCapture = V4L2_BUF_TYPE_VIDEO_CAPTURE;
constexpr std::uint32_t kNeeded = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;

Time StampOf(const timeval& stamp) {
  return Time{std::chrono::seconds(stamp.tv_sec) + std::chrono::microseconds(stamp.tv_usec)};
}

}  // namespace

int VideoCalls::Open(const char* path) { return open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC); }
void VideoCalls::Close(int file) { close(file); }
int VideoCalls::Ioctl(int file, unsigned long request, void* argument) {
  return ioctl(file, request, argument);
}
void* VideoCalls::Map(int file, std::size_t bytes, std::int64_t offset) {
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, offset);
  return memory == MAP_FAILED ? nullptr : memory;
}
void VideoCalls::Unmap(void* memory, std::size_t bytes) { munmap(memory, bytes); }

V4l2Depth::V4l2Depth(std::string path, const CameraIntrinsics& camera, Duration stamp_offset)
    : V4l2Depth(std::move(path), camera, stamp_offset, own_calls_) {}

V4l2Depth::V4l2Depth(std::string path, const CameraIntrinsics& camera, Duration stamp_offset,
                     VideoCalls& calls)
    : path_(std::move(path)), camera_(camera), stamp_offset_(stamp_offset), calls_(calls) {}

int V4l2Depth::Call(unsigned long request, void* argument) {
  int result = -1;
  do {
    result = calls_.Ioctl(file_, request, argument);
  } while (result != 0 && errno == EINTR);
  return result;
}

void V4l2Depth::Close() {
  if (file_ < 0) {
    return;
  }
  if (streaming_) {
    auto type = static_cast<int>(kCapture);
    Call(VIDIOC_STREAMOFF, &type);
  }
  for (Buffer& buffer : buffers_) {
    if (buffer.memory != nullptr) {
      calls_.Unmap(buffer.memory, buffer.bytes);
    }
    buffer = Buffer{};
  }
  calls_.Close(file_);
  file_ = -1;
  streaming_ = false;
}

Status V4l2Depth::Fail(const char* what, int error) {
  std::snprintf(error_, sizeof error_, "%s: %s%s%s", path_.c_str(), what, error != 0 ? ": " : "",
                error != 0 ? std::strerror(error) : "");
  Close();
  return Status::kUnavailable;
}

v4l2_buffer V4l2Depth::Description(std::uint32_t index) const {
  v4l2_buffer buffer{};
  buffer.type = kCapture;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

Status V4l2Depth::SetFormat() {
  v4l2_capability about{};
  if (Call(VIDIOC_QUERYCAP, &about) != 0) {
    return Fail("not a video device", errno);
  }
  const std::uint32_t can =
      (about.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? about.device_caps : about.capabilities;
  if ((can & kNeeded) != kNeeded) {
    return Fail("not a camera that streams; another /dev/video of it may be");
  }
  v4l2_format format{};
  format.type = kCapture;
  format.fmt.pix.width = static_cast<std::uint32_t>(camera_.width);
  format.fmt.pix.height = static_cast<std::uint32_t>(camera_.height);
  format.fmt.pix.pixelformat = V4L2_PIX_FMT_Z16;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  if (Call(VIDIOC_S_FMT, &format) != 0) {
    return Fail("refuses the format", errno);
  }
  const v4l2_pix_format& got = format.fmt.pix;
  if (got.pixelformat != V4L2_PIX_FMT_Z16) {
    return Fail("does not give depth (Z16); another /dev/video of it may");
  }
  if (got.width != static_cast<std::uint32_t>(camera_.width) ||
      got.height != static_cast<std::uint32_t>(camera_.height)) {
    char what[80];
    std::snprintf(what, sizeof what, "gives %ux%u, not the %dx%d asked for", got.width, got.height,
                  camera_.width, camera_.height);
    return Fail(what);
  }
  line_bytes_ = got.bytesperline >= 2 * got.width ? got.bytesperline : 2 * got.width;
  return Status::kOk;
}

Status V4l2Depth::MapBuffers() {
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = kCapture;
  request.memory = V4L2_MEMORY_MMAP;
  if (Call(VIDIOC_REQBUFS, &request) != 0) {
    return Fail(errno == EBUSY ? "another process has the camera" : "gives no buffers", errno);
  }
  if (request.count < 2) {
    return Fail("gives too few buffers");
  }
  for (std::uint32_t i = 0; i < request.count && i < kBuffers; ++i) {
    v4l2_buffer buffer = Description(i);
    if (Call(VIDIOC_QUERYBUF, &buffer) != 0) {
      return Fail("does not tell of its buffers", errno);
    }
    buffers_[i].memory = calls_.Map(file_, buffer.length, buffer.m.offset);
    buffers_[i].bytes = buffer.length;
    if (buffers_[i].memory == nullptr) {
      return Fail("its buffers cannot be mapped", errno);
    }
    if (Call(VIDIOC_QBUF, &buffer) != 0) {
      return Fail("does not take its buffers", errno);
    }
  }
  return Status::kOk;
}

Status V4l2Depth::Open(Time now) {
  if (now < next_try_) {
    return Status::kUnavailable;
  }
  next_try_ = now + kRetry;
  file_ = calls_.Open(path_.c_str());
  if (file_ < 0) {
    return Fail(errno == EACCES ? "not ours to open (group video)" : "cannot be opened", errno);
  }
  if (const Status status = SetFormat(); status != Status::kOk) {
    return status;
  }
  if (const Status status = MapBuffers(); status != Status::kOk) {
    return status;
  }
  auto type = static_cast<int>(kCapture);
  if (Call(VIDIOC_STREAMON, &type) != 0) {
    return Fail("does not stream", errno);
  }
  streaming_ = true;
  return Status::kOk;
}

/// One buffer off the device's queue, into `frame` if it is whole, and back.
Status V4l2Depth::Take(DepthFrame& frame, bool* taken) {
  v4l2_buffer buffer = Description(0);
  if (Call(VIDIOC_DQBUF, &buffer) != 0) {
    return errno == EAGAIN ? Status::kTimeout : Fail("has gone", errno);
  }
  if (buffer.index >= kBuffers || buffers_[buffer.index].memory == nullptr) {
    return Fail("gives a buffer that is not its own");
  }
  const Buffer& from = buffers_[buffer.index];
  const auto width = static_cast<std::size_t>(camera_.width);
  const auto height = static_cast<std::size_t>(camera_.height);
  const std::size_t needed = (height - 1) * line_bytes_ + 2 * width;
  if ((buffer.flags & V4L2_BUF_FLAG_ERROR) != 0 || buffer.bytesused < needed ||
      from.bytes < needed) {
    ++damaged_;
  } else {
    for (std::size_t row = 0; row < height; ++row) {
      std::memcpy(frame.depth_mm.data() + row * width,
                  static_cast<const char*>(from.memory) + row * line_bytes_, 2 * width);
    }
    frame.camera = camera_;
    frame.sequence = buffer.sequence;
    frame.stamp = StampOf(buffer.timestamp) + stamp_offset_;
    *taken = true;
  }
  return Call(VIDIOC_QBUF, &buffer) == 0 ? Status::kOk : Fail("does not take its buffers", errno);
}

Status V4l2Depth::Poll(Time now, DepthFrame& frame) {
  if (file_ < 0) {
    if (const Status status = Open(now); status != Status::kOk) {
      return status;
    }
  }
  bool taken = false;
  Status status = Status::kOk;
  for (int i = 0; i < kBuffers && status == Status::kOk; ++i) {
    status = Take(frame, &taken);
  }
  if (status == Status::kUnavailable) {
    return status;
  }
  return taken ? Status::kOk : Status::kTimeout;
}

}  // namespace pipewright
