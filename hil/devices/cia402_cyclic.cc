// SPDX-License-Identifier: MIT
// What a node does with time: SYNC and PDOs, heartbeats and deadlines, errors, the drive's motion.
#include <algorithm>
#include <cmath>

#include "hil/devices/cia402_node.h"
#include "hil/devices/cia402_objects.h"

namespace pipewright::hil {
namespace {

// 1001h
constexpr std::uint32_t kGenericError = 0x01;
constexpr std::uint32_t kCommunicationError = 0x10;
constexpr std::uint32_t kDeviceError = 0x20;
constexpr std::uint32_t kPdoTooShort = 0x8210;  // EMCY

std::uint64_t PayloadOf(const can::Frame& frame) {
  std::uint64_t payload = 0;
  for (int i = std::min<int>(frame.dlc, 8) - 1; i >= 0; --i) {
    payload = (payload << 8) | frame.data[static_cast<std::size_t>(i)];
  }
  return payload;
}

std::uint32_t ToUnits(double value) {
  const double units = std::clamp(value / can::kRadPerUnit, -0x1p31, 0x1p31 - 1);
  return static_cast<std::uint32_t>(std::llround(units));
}

}  // namespace

void Cia402Node::Measure(double position_rad, std::optional<double> velocity_radps) {
  if (!std::isfinite(position_rad) || !std::isfinite(velocity_radps.value_or(0))) {
    return;
  }
  measured_ = true;
  position_rad_ = position_rad;
  velocity_radps_ = velocity_radps;
  PublishState();
}

void Cia402Node::PublishState() {
  dictionary_.Set(0x6041, 0, drive_.Statusword(ModeIsCsv()));
  dictionary_.Set(0x6064, 0, ToUnits(position_rad_));
  dictionary_.Set(0x606C, 0, ToUnits(velocity_radps_.value_or(drive_.velocity_radps())));
}

void Cia402Node::OnSync(Time now) {
  if (nmt_ != NmtState::kOperational) {
    return;
  }
  for (ReceivePdo& receive : receive_) {
    if (receive.pending) {
      const std::uint64_t payload = *receive.pending;
      receive.pending.reset();
      Apply(receive, payload, now);
    }
  }
  for (TransmitPdo& transmit : transmit_) {
    if (!transmit.pdo.enabled() || !transmit.pdo.synchronous()) {
      continue;
    }
    const int every = transmit.pdo.type();
    const bool changed = !transmit.sent || transmit.pdo.Pack() != transmit.last_payload;
    if (every == 0 ? changed : ++transmit.syncs >= every) {
      Send(transmit, now);
    }
  }
}

void Cia402Node::OnReceivePdo(ReceivePdo& receive, const can::Frame& frame, Time now) {
  if (nmt_ != NmtState::kOperational) {
    return;
  }
  if (frame.dlc < receive.pdo.bytes()) {
    ++rejected_;
    SendEmergency(kPdoTooShort);
    return;
  }
  if (receive.pdo.synchronous()) {
    receive.pending = PayloadOf(frame);
  } else {
    Apply(receive, PayloadOf(frame), now);
  }
}

void Cia402Node::Apply(ReceivePdo& receive, std::uint64_t payload, Time now) {
  receive.applied = now;
  receive.pdo.Unpack(payload);
  for (const std::uint32_t entry : receive.pdo.entries()) {
    OnWritten(static_cast<std::uint16_t>(entry >> 16), static_cast<std::uint8_t>(entry >> 8));
  }
}

void Cia402Node::Send(TransmitPdo& transmit, Time now) {
  std::uint64_t payload = transmit.pdo.Pack();
  transmit.last_payload = payload;
  transmit.sent = true;
  transmit.last_sent = now;
  transmit.syncs = 0;
  can::Frame frame{.id = transmit.pdo.cob_id(),
                   .dlc = static_cast<std::uint8_t>(transmit.pdo.bytes())};
  for (std::uint8_t& byte : frame.data) {
    byte = static_cast<std::uint8_t>(payload & 0xFF);
    payload >>= 8;
  }
  outbox_.push_back(frame);
}

void Cia402Node::SendEventPdos(Time now) {
  if (nmt_ != NmtState::kOperational) {
    return;
  }
  for (TransmitPdo& transmit : transmit_) {
    const Pdo& pdo = transmit.pdo;
    if (!pdo.enabled() || pdo.synchronous()) {
      continue;
    }
    const Duration age = now - transmit.last_sent;
    const bool changed = !transmit.sent || pdo.Pack() != transmit.last_payload;
    const bool timer = pdo.timer() > Duration::zero() && age >= pdo.timer();
    if (timer || (changed && (!transmit.sent || age >= pdo.inhibit()))) {
      Send(transmit, now);
    }
  }
}

void Cia402Node::SendEmergency(std::uint32_t code, std::uint32_t vendor) {
  if (nmt_ == NmtState::kStopped || nmt_ == NmtState::kBootUp) {
    return;
  }
  Queue(can::kEmergency,
        can::Emergency{
            .code = code, .error_register = dictionary_.Value(0x1001, 0), .vendor = vendor});
}

void Cia402Node::NoteError(std::uint32_t emcy_code, std::uint32_t register_bits,
                           std::uint32_t vendor) {
  dictionary_.Set(0x1001, 0, dictionary_.Value(0x1001, 0) | kGenericError | register_bits);
  dictionary_.Set(0x603F, 0, emcy_code);
  for (std::uint8_t i = 4; i > 1; --i) {
    dictionary_.Set(0x1003, i, dictionary_.Value(0x1003, static_cast<std::uint8_t>(i - 1)));
  }
  dictionary_.Set(0x1003, 1, emcy_code);
  dictionary_.Set(0x1003, 0, std::min(dictionary_.Value(0x1003, 0) + 1, 4U));
  SendEmergency(emcy_code, vendor);
}

void Cia402Node::ClearErrors() {
  const bool faulty =
      drive_.state() == DriveState::kFault || drive_.state() == DriveState::kFaultReaction;
  if (faulty || host_lost_ || internal_fault_ != 0 || dictionary_.Value(0x1001, 0) == 0) {
    return;
  }
  dictionary_.Set(0x1001, 0, 0);
  dictionary_.Set(0x603F, 0, 0);
  SendEmergency(can::emergency::kNone);
}

void Cia402Node::RaiseInternalFault(std::uint16_t emcy_code, std::uint32_t vendor) {
  internal_fault_ = emcy_code;
  internal_vendor_ = vendor;
  drive_.RaiseFault();
  NoteError(emcy_code, kDeviceError, vendor);
}

void Cia402Node::ClearInternalFault() { internal_fault_ = 0; }

/// 6007h, abort connection: 0 nothing, 1 fault, 2 disable voltage, 3 quick stop.
void Cia402Node::LoseConnection(std::uint32_t emcy_code) {
  NoteError(emcy_code, kCommunicationError);
  const DriveState state = drive_.state();
  if (state != DriveState::kOperationEnabled && state != DriveState::kQuickStopActive) {
    return;
  }
  switch (dictionary_.Value(0x6007, 0)) {
    case 1:
      return drive_.RaiseFault();
    case 2:
      return drive_.Command(can::controlword::kDisableVoltage);
    case 3:
      return drive_.Command(can::controlword::kQuickStop);
    default:
      return;
  }
}

/// A drive that is driven by SDO has no RPDO whose deadline could pass.
bool Cia402Node::OrdersLate(Time now) const {
  const Duration limit = receive_.front().pdo.timer();
  const bool follows = drive_.state() == DriveState::kOperationEnabled && ModeIsCsv() &&
                       dictionary_.Value(0x60FF, 0) != 0;
  return follows && ordered_ && limit > Duration::zero() && now - *ordered_ > limit;
}

void Cia402Node::CheckDeadlines(Time now) {
  bool lost = false;
  const std::chrono::milliseconds host_limit(dictionary_.Value(0x1016, 1) & 0xFFFF);
  if (host_seen_ && host_limit.count() > 0 && now - *host_seen_ > host_limit) {
    host_seen_.reset();
    host_lost_ = true;
    lost = true;
    LoseConnection(can::emergency::kHeartbeatLost);
  }
  for (ReceivePdo& receive : receive_) {
    const Duration limit = receive.pdo.timer();
    const bool late = receive.applied && limit > Duration::zero() && now - *receive.applied > limit;
    if (late && drive_.state() == DriveState::kOperationEnabled) {
      receive.applied.reset();
      ordered_.reset();
      lost = true;
      LoseConnection(can::emergency::kPdoLost);
    }
  }
  if (OrdersLate(now)) {
    ordered_.reset();  // told once
    lost = true;
    LoseConnection(can::emergency::kPdoLost);
  }
  const std::uint32_t behaviour = dictionary_.Value(0x1029, 1);
  if (lost && nmt_ == NmtState::kOperational && behaviour != 1) {
    SetNmt(behaviour == 0 ? NmtState::kPreOperational : NmtState::kStopped);
  }
  drive_.HoldFault(host_lost_ || internal_fault_ != 0);
}

void Cia402Node::SendHeartbeat(Time now) {
  if (nmt_ == NmtState::kBootUp) {
    if (!measured_) {
      return;
    }
    boot_at_ = boot_at_ ? boot_at_ : now + config_.boot_time;
    if (now < *boot_at_) {
      return;
    }
    Queue(can::kHeartbeat, can::Heartbeat{static_cast<std::uint32_t>(NmtState::kBootUp)});
    nmt_ = NmtState::kPreOperational;
    drive_.PowerUp();
    if (internal_fault_ != 0) {
      RaiseInternalFault(internal_fault_, internal_vendor_);  // a reset mends nothing
    }
  }
  const std::chrono::milliseconds period(dictionary_.Value(0x1017, 0));
  if (period.count() == 0) {
    return;
  }
  if (!next_heartbeat_) {
    next_heartbeat_ = now + period;
  }
  if (now >= *next_heartbeat_) {
    *next_heartbeat_ += period;
    Queue(can::kHeartbeat, can::Heartbeat{static_cast<std::uint32_t>(nmt_)});
  }
}

void Cia402Node::Step(Time now, std::vector<can::Frame>& out) {
  const Duration since = stepped_ ? now - last_ : Duration::zero();
  stepped_ = true;
  last_ = now;
  SendHeartbeat(now);
  CheckDeadlines(now);
  drive_.Step(ToSeconds(std::max(since, Duration::zero())),
              static_cast<double>(dictionary_.Find(0x60FF, 0)->Signed()) * can::kRadPerUnit,
              ModeIsCsv(), position_rad_, LimitsOf(dictionary_));
  PublishState();
  SendEventPdos(now);
  out.insert(out.end(), outbox_.begin(), outbox_.end());
  outbox_.clear();
}

}  // namespace pipewright::hil
