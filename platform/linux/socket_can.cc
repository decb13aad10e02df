// SPDX-License-Identifier: MIT
#include "platform/linux/socket_can.h"

#include <linux/can/raw.h>
#include <linux/sock_diag.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "platform/linux/clock.h"

namespace pipewright {
namespace {

bool CanExist(const can::Frame& frame) {
  return !frame.error && frame.dlc <= CAN_MAX_DLEN &&
         frame.id <= (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
}

/// One frame, and the kernel's count of frames that it had no room for.
ssize_t ReadFrame(int socket, can_frame& frame, std::uint32_t& overflows) {
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(std::uint32_t))];
  iovec vector{&frame, sizeof frame};
  msghdr message{};
  message.msg_iov = &vector;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t size = recvmsg(socket, &message, 0);
  const cmsghdr* told = size < 0 ? nullptr : CMSG_FIRSTHDR(&message);
  if (told != nullptr && told->cmsg_level == SOL_SOCKET && told->cmsg_type == SO_RXQ_OVFL) {
    std::memcpy(&overflows, CMSG_DATA(told), sizeof overflows);
  }
  return size;
}

}  // namespace

can_frame ToKernel(const can::Frame& frame) {
  can_frame kernel{};
  kernel.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0U) |
                  (frame.remote ? CAN_RTR_FLAG : 0U) | (frame.error ? CAN_ERR_FLAG : 0U);
  kernel.can_dlc = frame.dlc;
  std::copy(frame.data.begin(), frame.data.end(), kernel.data);
  return kernel;
}

can::Frame FromKernel(const can_frame& kernel) {
  can::Frame frame;
  frame.error = (kernel.can_id & CAN_ERR_FLAG) != 0;
  frame.extended = !frame.error && (kernel.can_id & CAN_EFF_FLAG) != 0;
  frame.remote = !frame.error && (kernel.can_id & CAN_RTR_FLAG) != 0;
  frame.id = kernel.can_id & (frame.error || frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.dlc = static_cast<std::uint8_t>(std::min<int>(kernel.can_dlc, CAN_MAX_DLEN));
  for (int i = 0; i < frame.dlc && !frame.remote; ++i) {
    frame.data[i] = kernel.data[i];
  }
  return frame;
}

Status SocketCan::Open(std::string_view interface) {
  Close();
  if (interface.empty() || interface.size() >= IFNAMSIZ) {
    errno_ = EINVAL;
    std::snprintf(error_, sizeof error_, "an interface name has 1 to %d characters", IFNAMSIZ - 1);
    return Status::kMalformed;
  }
  char name[IFNAMSIZ] = "";
  interface.copy(name, interface.size());

  socket_ = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (socket_ < 0) {
    return Fail("socket(PF_CAN)", errno);
  }
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(if_nametoindex(name));
  if (address.can_ifindex == 0) {
    return Fail(name, errno);
  }
  if (const Status status = Check(name); status != Status::kOk) {
    return status;
  }
  const int yes = 1;
  if (setsockopt(socket_, SOL_SOCKET, SO_RXQ_OVFL, &yes, sizeof yes) != 0) {
    return Fail("setsockopt(SO_RXQ_OVFL)", errno);
  }
  const can_err_mask_t errors = CAN_ERR_MASK;
  if (setsockopt(socket_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) != 0) {
    return Fail("setsockopt(CAN_RAW_ERR_FILTER)", errno);
  }
  if (bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return Fail("bind", errno);
  }
  healthy_ = true;
  rx_overflows_ = 0;
  return Status::kOk;
}

/// bind() takes an interface that is down, and calls one that is not CAN "no such device".
Status SocketCan::Check(const char* name) {
  ifreq request{};
  std::snprintf(request.ifr_name, sizeof request.ifr_name, "%s", name);
  if (ioctl(socket_, SIOCGIFHWADDR, &request) != 0) {
    return Fail(name, errno);
  }
  if (request.ifr_hwaddr.sa_family != ARPHRD_CAN) {
    std::snprintf(error_, sizeof error_, "%s: not a CAN interface", name);
    errno_ = EINVAL;
    Close();
    return Status::kUnavailable;
  }
  if (ioctl(socket_, SIOCGIFFLAGS, &request) != 0) {
    return Fail(name, errno);
  }
  return (request.ifr_flags & IFF_UP) != 0 ? Status::kOk : Fail(name, ENETDOWN);
}

void SocketCan::GrowReceiveQueue(int frames) {
  constexpr int kBytesPerFrame = 1024;            // the kernel counts its own bookkeeping, too
  const int bytes = frames * kBytesPerFrame / 2;  // and doubles what it is asked for
  // Beyond the system's limit if that is allowed, else up to it.
  if (setsockopt(socket_, SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes) != 0) {
    static_cast<void>(setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes));
  }
}

void SocketCan::Discard() {
  constexpr int kMost = 65536;  // on a wire that never falls silent
  can_frame kernel{};
  std::uint32_t overflows = 0;
  for (int i = 0; i < kMost && ReadFrame(socket_, kernel, overflows) > 0; ++i) {
  }
  std::uint32_t memory[SK_MEMINFO_VARS] = {};
  socklen_t size = sizeof memory;
  if (getsockopt(socket_, SOL_SOCKET, SO_MEMINFO, memory, &size) == 0) {
    rx_overflows_ = memory[SK_MEMINFO_DROPS];
  }
  rx_dropped_ = 0;
}

void SocketCan::Close() {
  if (socket_ >= 0) {
    close(socket_);
  }
  socket_ = -1;
  healthy_ = false;
}

Status SocketCan::Send(const can::Frame& frame) {
  if (!CanExist(frame)) {
    return Status::kMalformed;
  }
  if (socket_ < 0) {
    ++tx_dropped_;
    return Status::kUnavailable;
  }
  const can_frame kernel = ToKernel(frame);
  if (write(socket_, &kernel, sizeof kernel) == static_cast<ssize_t>(sizeof kernel)) {
    ++tx_;
    healthy_ = true;
    return Status::kOk;
  }
  ++tx_dropped_;
  const int error = errno;
  if (error == ENOBUFS || error == EAGAIN || error == EINTR) {
    return Status::kFull;
  }
  healthy_ = false;
  errno_ = error;
  std::snprintf(error_, sizeof error_, "write: %s", std::strerror(error));
  return Status::kUnavailable;
}

bool SocketCan::Receive(can::Frame& frame) {
  if (socket_ < 0) {
    return false;
  }
  can_frame kernel{};
  std::uint32_t overflows = rx_overflows_;
  const ssize_t size = ReadFrame(socket_, kernel, overflows);
  if (size != static_cast<ssize_t>(sizeof kernel)) {
    if (size < 0 && errno != EAGAIN && errno != EINTR) {
      healthy_ = false;
      errno_ = errno;
      std::snprintf(error_, sizeof error_, "read: %s", std::strerror(errno_));
    }
    return false;
  }
  frame = FromKernel(kernel);
  frame.stamp = Now();
  ++rx_;
  healthy_ = true;
  rx_dropped_ += overflows - rx_overflows_;
  rx_overflows_ = overflows;
  return true;
}

Status SocketCan::Fail(const char* call, int error) {
  errno_ = error;
  std::snprintf(error_, sizeof error_, "%s: %s", call, std::strerror(error));
  Close();
  return Status::kUnavailable;
}

}  // namespace pipewright
