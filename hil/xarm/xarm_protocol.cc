// SPDX-License-Identifier: MIT
#include "hil/xarm/xarm_protocol.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "hil/xarm/wire_bytes.h"

namespace pipewright::hil {
namespace {

using namespace wire_bytes;  // NOLINT: one room's names

constexpr std::uint8_t kAllJoints = 8;
constexpr std::size_t kVelocityBytes = 4 * kXarmJoints + 1;
constexpr double kDurationMax_s = 1;

XarmFrame Request(XarmRegister reg, std::span<const std::uint8_t> parameters) {
  XarmFrame frame;
  frame.register_number = static_cast<std::uint8_t>(reg);
  frame.size = parameters.size();
  std::copy(parameters.begin(), parameters.end(), frame.data.begin());
  return frame;
}

/// The number that begins `text`, which then begins after it.
bool TakeNumber(std::string_view& text, int& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || number < 0) {
    return false;
  }
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

bool TakeDot(std::string_view& text) {
  const bool dot = text.starts_with('.');
  text.remove_prefix(dot ? 1 : 0);
  return dot;
}

}  // namespace

Result<std::size_t> XarmFrameBytes(Bytes bytes) {
  if (bytes.size() < XarmFrame::kHeaderBytes) {
    return std::size_t{0};
  }
  const std::size_t length = Integer(bytes, 4, 2);
  if (length < 1 || length > 1 + XarmFrame::kPayloadMax) {
    return Status::kMalformed;
  }
  return XarmFrame::kHeaderBytes + length;
}

Result<XarmFrame> DecodeXarmFrame(Bytes bytes) {
  const Result<std::size_t> size = XarmFrameBytes(bytes);
  if (!size.ok() || *size == 0 || *size != bytes.size()) {
    return Status::kMalformed;
  }
  XarmFrame frame;
  frame.transaction = static_cast<std::uint16_t>(Integer(bytes, 0, 2));
  frame.protocol = static_cast<std::uint16_t>(Integer(bytes, 2, 2));
  frame.register_number = bytes[XarmFrame::kHeaderBytes];
  const Bytes payload = bytes.subspan(XarmFrame::kHeaderBytes + 1);
  frame.size = payload.size();
  std::copy(payload.begin(), payload.end(), frame.data.begin());
  return frame;
}

std::size_t EncodeXarmFrame(const XarmFrame& frame,
                            std::span<std::uint8_t, XarmFrame::kBytesMax> room) {
  PutInteger(room, 0, 2, frame.transaction);
  PutInteger(room, 2, 2, frame.protocol);
  PutInteger(room, 4, 2, frame.size + 1);
  room[XarmFrame::kHeaderBytes] = frame.register_number;
  std::copy_n(frame.data.begin(), frame.size, room.begin() + XarmFrame::kHeaderBytes + 1);
  return XarmFrame::kHeaderBytes + 1 + frame.size;
}

XarmFrame XarmAsk(XarmRegister reg) { return Request(reg, {}); }

XarmFrame XarmMotionEnable(bool enable) {
  return Request(XarmRegister::kMotionEnable,
                 std::array<std::uint8_t, 2>{kAllJoints, static_cast<std::uint8_t>(enable)});
}

XarmFrame XarmSetState(int state) {
  return Request(XarmRegister::kSetState, std::array{static_cast<std::uint8_t>(state)});
}

XarmFrame XarmSetMode(int mode) {
  return Request(XarmRegister::kSetMode, std::array{static_cast<std::uint8_t>(mode)});
}

Result<XarmFrame> XarmVelocityRequest(const XarmVelocity& velocity) {
  // Written so that what is not a number fails, too.
  const auto& v = velocity.velocity_radps;
  const bool fits = (v.array().abs() <= kXarmSpeedLimit_radps).all() && velocity.duration_s > 0 &&
                    velocity.duration_s <= kDurationMax_s;
  if (!fits) {
    return Status::kOutOfRange;
  }
  XarmFrame frame = XarmAsk(XarmRegister::kJointVelocity);
  frame.size = kVelocityBytes + 4;
  for (std::size_t i = 0; i < kXarmJoints; ++i) {
    PutFloat(frame.data, 4 * i, v(static_cast<Eigen::Index>(i)));
  }
  frame.data[kVelocityBytes - 1] = velocity.together ? 1 : 0;
  PutFloat(frame.data, kVelocityBytes, velocity.duration_s);
  return frame;
}

Result<XarmVelocity> DecodeXarmVelocity(const XarmFrame& request) {
  const bool ends = request.size == kVelocityBytes + 4;
  if (request.reg() != XarmRegister::kJointVelocity || (!ends && request.size != kVelocityBytes)) {
    return Status::kMalformed;
  }
  XarmVelocity velocity;
  for (std::size_t i = 0; i < kXarmJoints; ++i) {
    velocity.velocity_radps(static_cast<Eigen::Index>(i)) = Float(request.data, 4 * i);
  }
  velocity.together = request.data[kVelocityBytes - 1] != 0;
  velocity.duration_s = ends ? Float(request.data, kVelocityBytes) : 0;
  if (!velocity.velocity_radps.allFinite() || !std::isfinite(velocity.duration_s)) {
    return Status::kOutOfRange;
  }
  return velocity;
}

XarmFrame XarmResponse(const XarmFrame& request, std::uint8_t state, Bytes values) {
  XarmFrame response;
  response.transaction = request.transaction;
  response.protocol = request.protocol;
  response.register_number = request.register_number;
  const Bytes fitting = values.first(std::min(values.size(), XarmFrame::kPayloadMax - 1));
  response.data[0] = state;
  std::copy(fitting.begin(), fitting.end(), response.data.begin() + 1);
  response.size = 1 + fitting.size();
  return response;
}

Result<XarmErrors> DecodeXarmErrors(const XarmFrame& response) {
  if (response.reg() != XarmRegister::kGetError || response.size != 3) {
    return Status::kMalformed;
  }
  return XarmErrors{response.data[1], response.data[2]};
}

Result<XarmVersion> DecodeXarmVersion(const XarmFrame& response) {
  if (response.reg() != XarmRegister::kVersion || response.size < 2) {
    return Status::kMalformed;
  }
  const Bytes bytes = response.payload().subspan(1);
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  text = text.substr(0, text.find('\0'));
  XarmVersion version;
  if (!TakeNumber(text, version.axes)) {
    return Status::kMalformed;
  }
  // The firmware is what follows the last v: names of arms and boxes have none.
  const std::size_t v = text.find_last_of("vV");
  if (v == std::string_view::npos) {
    return Status::kMalformed;
  }
  text.remove_prefix(v + 1);
  const bool whole = TakeNumber(text, version.major) && TakeDot(text) &&
                     TakeNumber(text, version.minor) && TakeDot(text) &&
                     TakeNumber(text, version.revision);
  if (!whole) {
    return Status::kMalformed;
  }
  return version;
}

}  // namespace pipewright::hil
