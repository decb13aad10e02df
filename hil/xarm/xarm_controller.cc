// SPDX-License-Identifier: MIT
#include "hil/xarm/xarm_controller.h"

#include <algorithm>

#include "hil/xarm/wire_bytes.h"

namespace pipewright::hil {
namespace {

constexpr std::size_t kVersionBytes = 40;
/// The same requests; so the vendor's client says, to firmware of 1.8.6 and later, that it will not
/// be silent for long (SDK, x3/base.py).
constexpr std::uint16_t kPrivateProtocolKeptUp = 3;
constexpr int kJointLimitError = 23;  ///< SDK, x_code.py: angle limit exceeded

}  // namespace

XarmController::XarmController(const XarmControllerConfig& config)
    : config_(config), position_rad_(config.start_rad) {}

std::string XarmController::Open() {
  std::string error = request_listener_.Open(config_.address, config_.request_port);
  error = error.empty() ? real_listener_.Open(config_.address, config_.real_port) : error;
  return error.empty() ? real_time_listener_.Open(config_.address, config_.real_time_port) : error;
}

void XarmController::Accept(Time now) {
  const auto accept = [&](TcpListener& from, std::optional<XarmReportKind> report) {
    for (Descriptor socket = from.Accept(); socket.open(); socket = from.Accept()) {
      clients_.push_back(std::make_unique<Client>(
          Client{TcpStream(std::move(socket)), report, now, std::deque<Message>{}}));
    }
  };
  accept(request_listener_, {});
  accept(real_listener_, XarmReportKind::kReal);
  accept(real_time_listener_, XarmReportKind::kRealTime);
}

void XarmController::Step(Time now) {
  Accept(now);
  for (const auto& client : clients_) {
    client->stream.Poll();
    if (client->report) {
      client->stream.Take(client->stream.received().size());
    } else if (!deaf_) {
      Hear(*client, now);
    }
  }
  Move(now);
  ++steps_;
  for (const auto& client : clients_) {
    if (client->report && !silent_) {
      Report(*client, now);
    }
    Flush(*client, now);
  }
  std::erase_if(clients_, [](const auto& client) { return !client->stream.open(); });
}

void XarmController::Hear(Client& client, Time now) {
  while (true) {
    const Result<std::size_t> size = XarmFrameBytes(client.stream.received());
    if (!size.ok()) {
      return client.stream.Close();
    }
    if (*size == 0 || *size > client.stream.received().size()) {
      return;
    }
    const Result<XarmFrame> request = DecodeXarmFrame(client.stream.received().first(*size));
    client.stream.Take(*size);
    if (!request.ok() || (request->protocol != XarmFrame::kPrivateProtocol &&
                          request->protocol != kPrivateProtocolKeptUp)) {
      continue;  // the vendor's heartbeat
    }
    heard_.push_back(*request);
    const XarmFrame answer = Answer(*request, now);
    std::array<std::uint8_t, XarmFrame::kBytesMax> room{};
    const std::size_t bytes = EncodeXarmFrame(answer, room);
    client.out.push_back({now + config_.answer_delay,
                          {room.begin(), room.begin() + static_cast<std::ptrdiff_t>(bytes)}});
  }
}

XarmFrame XarmController::Answer(const XarmFrame& request, Time now) {
  const auto values = [&](std::initializer_list<int> bytes) {
    std::vector<std::uint8_t> data;
    for (const int byte : bytes) {
      data.push_back(static_cast<std::uint8_t>(byte));
    }
    return XarmResponse(request, StateByte(), data);
  };
  switch (request.reg()) {
    case XarmRegister::kVersion: {
      std::array<std::uint8_t, kVersionBytes> text{};  // zero-filled: the vendor's client drops one
      std::copy_n(config_.version.begin(), std::min(config_.version.size(), text.size() - 1),
                  text.begin());
      return XarmResponse(request, StateByte(), text);
    }
    case XarmRegister::kMotionEnable:
      return Set(request, request.size == 2 ? request.data[1] : -1);
    case XarmRegister::kSetState:
      return Set(request, request.size == 1 ? request.data[0] : -1);
    case XarmRegister::kSetMode:  // the vendor's client adds how transitions are to be detected
      return Set(request, request.size == 1 || request.size == 2 ? request.data[0] : -1);
    case XarmRegister::kCleanError:
    case XarmRegister::kCleanWarning:
      return Set(request, 0);
    case XarmRegister::kGetState:
      return values({state_});
    case XarmRegister::kQueuedCommands:
      return values({0, 0});
    case XarmRegister::kGetError:
      return values({error(), 0});
    case XarmRegister::kJointPositions: {
      std::array<std::uint8_t, 4 * kXarmJoints> data{};
      for (std::size_t i = 0; i < kXarmJoints; ++i) {
        wire_bytes::PutFloat(data, 4 * i, position_rad_(static_cast<Eigen::Index>(i)));
      }
      return XarmResponse(request, StateByte(), data);
    }
    case XarmRegister::kJointVelocity:
      return Velocity(request, now);
  }
  return XarmResponse(request, StateByte());  // the vendor's client asks for more
}

XarmFrame XarmController::Set(const XarmFrame& request, int value) {
  if (value < 0 || value > 7) {
    return XarmResponse(request, StateByte() | xarm_status::kInvalid);
  }
  switch (request.reg()) {
    case XarmRegister::kMotionEnable:
      enabled_ = value != 0;
      state_ = xarm_state::kReset;
      break;
    case XarmRegister::kSetMode:
      mode_ = value;
      state_ = xarm_state::kReset;
      break;
    case XarmRegister::kCleanError:
      error_ = 0;
      state_ = xarm_state::kReset;
      break;
    case XarmRegister::kSetState:
      if (value == xarm_state::kReady) {
        state_ = enabled_ && error() == 0 ? xarm_state::kSleeping : state_;
      } else {
        state_ = value;
      }
      break;
    default:
      break;
  }
  return XarmResponse(request, StateByte());
}

XarmFrame XarmController::Velocity(const XarmFrame& request, Time now) {
  const Result<XarmVelocity> velocity = DecodeXarmVelocity(request);
  if (!velocity.ok()) {
    return XarmResponse(request, StateByte() | xarm_status::kInvalid);
  }
  if (mode_ != xarm_mode::kJointVelocity || !CanMove()) {
    return XarmResponse(request, StateByte() | xarm_status::kCannotMove);
  }
  target_radps_ = velocity->velocity_radps;
  target_until_.reset();
  if (velocity->duration_s > 0) {
    target_until_ = now + FromSeconds(velocity->duration_s);
  }
  return XarmResponse(request, StateByte());
}

bool XarmController::CanMove() const {
  return enabled_ && error() == 0 && xarm_state::Moves(state_);
}

std::uint8_t XarmController::StateByte() const {
  return static_cast<std::uint8_t>((error() != 0 ? xarm_status::kError : 0) |
                                   (CanMove() ? 0 : xarm_status::kCannotMove));
}

void XarmController::Move(Time now) {
  const double dt_s = stepped_ ? ToSeconds(now - *stepped_) : 0;
  stepped_ = now;
  if (error() != 0) {
    state_ = xarm_state::kStopped;
  }
  const bool expired = target_until_ && now >= *target_until_;
  if (expired || !CanMove() || mode_ != xarm_mode::kJointVelocity) {
    target_radps_.setZero();
    target_until_.reset();
  }
  const double step = config_.accel_radps2 * dt_s;
  velocity_radps_ += (target_radps_ - velocity_radps_).cwiseMax(-step).cwiseMin(step);
  position_rad_ += velocity_radps_ * dt_s;
  if ((position_rad_.array().abs() > config_.limit_rad).any()) {
    position_rad_ = position_rad_.cwiseMax(-config_.limit_rad).cwiseMin(config_.limit_rad);
    velocity_radps_.setZero();
    InjectError(kJointLimitError);
  }
  if (xarm_state::Moves(state_)) {
    state_ = velocity_radps_.isZero(0) ? xarm_state::kSleeping : xarm_state::kMoving;
  }
}

void XarmController::Report(Client& client, Time now) {
  if (now < client.next_report) {
    return;
  }
  client.next_report = now + ReportPeriod(*client.report);
  const XarmReport report{
      .mode = mode_,
      .state = state_,
      .time_us = static_cast<std::uint64_t>(
          std::chrono::duration_cast<std::chrono::microseconds>(now.time_since_epoch()).count()),
      .position_rad = reported_.value_or(position_rad_),
      .velocity_radps = velocity_radps_};
  std::array<std::uint8_t, kXarmReportBytesMax> room{};
  const std::size_t bytes = EncodeXarmReport(*client.report, report, room);
  client.out.push_back({now, {room.begin(), room.begin() + static_cast<std::ptrdiff_t>(bytes)}});
}

void XarmController::Flush(Client& client, Time now) {
  if (steps_ % static_cast<std::uint64_t>(config_.steps_per_send) != 0) {
    return;
  }
  std::size_t left = config_.bytes_per_step == 0 ? SIZE_MAX : config_.bytes_per_step;
  while (!client.out.empty() && client.out.front().due <= now && left > 0) {
    std::vector<std::uint8_t>& bytes = client.out.front().bytes;
    const std::size_t count = std::min(left, bytes.size());
    if (!client.stream.Send({bytes.data(), count})) {
      return;
    }
    left -= count;
    bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
    if (bytes.empty()) {
      client.out.pop_front();
    }
  }
}

void XarmController::InjectError(int code) {
  error_ = code;
  state_ = xarm_state::kStopped;
}

void XarmController::SetStickyError(int code) {
  sticky_error_ = code;
  state_ = xarm_state::kStopped;
}

void XarmController::TakeOver(int mode, int state) {
  mode_ = mode;
  state_ = state;
}

void XarmController::Drop() { clients_.clear(); }

int XarmController::clients() const { return static_cast<int>(clients_.size()); }

std::uint64_t XarmController::sent(int port) const {
  std::uint64_t bytes = 0;
  for (const auto& client : clients_) {
    const int at = client->report ? report_port(*client->report) : request_port();
    bytes += at == port ? client->stream.sent() : 0;
  }
  return bytes;
}

std::uint64_t XarmController::arrived(int port) const {
  std::uint64_t bytes = 0;
  for (const auto& client : clients_) {
    const int at = client->report ? report_port(*client->report) : request_port();
    bytes += at == port ? client->stream.arrived() : 0;
  }
  return bytes;
}

}  // namespace pipewright::hil
