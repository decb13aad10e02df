// SPDX-License-Identifier: MIT
#include "hil/devices/cia402_node.h"

#include <cassert>

#include "hil/devices/cia402_objects.h"
#include "platform/can/sdo.h"

namespace pipewright::hil {
namespace {

constexpr std::uint32_t kStoppedByNmt = 0x8100;  // EMCY: communication, in general

}  // namespace

Cia402Node::Cia402Node(const Cia402Config& config) : config_(config) {
  assert(config.Valid());
  receive_.assign(2, {Pdo(0x1400, 0x1600, false), {}, {}});
  transmit_.assign(2, {Pdo(0x1800, 0x1A00, true)});
  dictionary_ = FactoryDictionary(config_, receive_, transmit_);
  ResetApplication();
}

void Cia402Node::ResetApplication() {
  ResetCommunication();
  dictionary_ = FactoryDictionary(config_, receive_, transmit_);
  ConfigurePdos();
  drive_.Restart();
}

/// Entries below 2000h go back to the factory's; the node is silent until booted again.
void Cia402Node::ResetCommunication() {
  const ObjectDictionary before = dictionary_;
  receive_ = {{Pdo(0x1400, 0x1600, false), {}, {}}, {Pdo(0x1401, 0x1601, false), {}, {}}};
  transmit_ = {{Pdo(0x1800, 0x1A00, true)}, {Pdo(0x1801, 0x1A01, true)}};
  dictionary_ = FactoryDictionary(config_, receive_, transmit_);
  dictionary_.TakeValues(before, 0x2000);
  ConfigurePdos();
  nmt_ = NmtState::kBootUp;
  boot_at_.reset();
  next_heartbeat_.reset();
  host_seen_.reset();
  host_lost_ = false;
}

void Cia402Node::ConfigurePdos() {
  for (ReceivePdo& receive : receive_) {
    receive.pdo.Configure(dictionary_);
  }
  for (TransmitPdo& transmit : transmit_) {
    transmit.pdo.Configure(dictionary_);
  }
}

bool Cia402Node::ModeIsCsv() const {
  return dictionary_.Value(0x6061, 0) == can::kModeCyclicVelocity;
}

void Cia402Node::OnFrame(const can::Frame& frame, Time now) {
  if (nmt_ == NmtState::kBootUp || frame.extended || frame.remote || frame.error) {
    return;
  }
  heard_ = now;
  const auto node = static_cast<std::uint32_t>(config_.node_id);
  if (frame.id == can::kNmt.head.id) {
    const Result<can::Nmt> request = can::Decode(can::kNmt, frame);
    request.ok() ? OnNmt(*request) : void(++rejected_);
  } else if (frame.id == can::kSync.head.id) {
    frame.dlc <= can::kSync.head.also_dlc ? OnSync(now) : void(++rejected_);
  } else if (frame.id == can::kSdoRequest.head.id + node) {
    auto row = can::kSdoRequest;
    row.head.max_node = 127;
    const Result<can::Sdo> request = can::Decode(row, frame);
    request.ok() ? OnSdo(*request) : void(++rejected_);
  } else if (can::NodeOf(can::kHeartbeat.head, frame.id) > 0) {
    OnHeartbeat(can::NodeOf(can::kHeartbeat.head, frame.id), now);
  } else {
    for (ReceivePdo& receive : receive_) {
      if (receive.pdo.enabled() && receive.pdo.cob_id() == frame.id) {
        OnReceivePdo(receive, frame, now);
      }
    }
  }
}

void Cia402Node::OnNmt(const can::Nmt& request) {
  if (request.node != 0 && request.node != static_cast<std::uint32_t>(config_.node_id)) {
    return;
  }
  switch (static_cast<can::NmtCommand>(request.command)) {
    case can::NmtCommand::kStart:
      return SetNmt(NmtState::kOperational);
    case can::NmtCommand::kStop:
      return SetNmt(NmtState::kStopped);
    case can::NmtCommand::kPreOperational:
      return SetNmt(NmtState::kPreOperational);
    case can::NmtCommand::kResetNode:
      return ResetApplication();
    case can::NmtCommand::kResetCommunication:
      SetNmt(NmtState::kPreOperational);
      return ResetCommunication();
  }
  ++rejected_;
}

void Cia402Node::SetNmt(NmtState state) {
  const bool leaves = nmt_ == NmtState::kOperational && state != NmtState::kOperational;
  if (nmt_ != NmtState::kOperational && state == NmtState::kOperational) {
    for (TransmitPdo& transmit : transmit_) {
      transmit.sent = false;  // an event-driven PDO is sent on entering the state
      transmit.syncs = 0;
    }
  }
  nmt_ = state;
  if (!leaves) {
    return;
  }
  for (ReceivePdo& receive : receive_) {
    receive.pending.reset();
    receive.applied.reset();
  }
  if (drive_.state() == DriveState::kOperationEnabled) {
    LoseConnection(kStoppedByNmt);
  }
}

void Cia402Node::OnHeartbeat(int node, Time now) {
  const std::uint32_t watched = dictionary_.Value(0x1016, 1) >> 16;
  if (static_cast<std::uint32_t>(node) != watched) {
    return;
  }
  host_seen_ = now;
  if (host_lost_) {
    host_lost_ = false;
    ClearErrors();
  }
}

void Cia402Node::OnSdo(const can::Sdo& request) {
  if (nmt_ == NmtState::kStopped) {
    return;
  }
  const can::SdoMeaning meaning = can::Meaning(request, /*from_server=*/false);
  const auto index = static_cast<std::uint16_t>(request.index);
  const auto sub = static_cast<std::uint8_t>(request.subindex);
  AbortCode why = AbortCode::kCommand;
  can::Sdo answer;
  switch (meaning.kind) {
    case can::SdoKind::kUploadRequest:
      why = dictionary_.CheckRead(index, sub);
      if (why == AbortCode::kNone) {
        const Object& object = *dictionary_.Find(index, sub);
        answer = can::UploadResponse(meaning.object, object.bytes, object.value);
      }
      break;
    case can::SdoKind::kDownloadRequest: {
      const bool sized = (request.command & 1) != 0;
      why = Write(index, sub, sized ? meaning.bytes : 0, meaning.value);
      answer = can::DownloadResponse(meaning.object);
      break;
    }
    case can::SdoKind::kAbort:
      return;  // the client gave up; there is nothing to undo in an expedited transfer
    case can::SdoKind::kUploadResponse:
    case can::SdoKind::kDownloadResponse:
    case can::SdoKind::kOther:
      break;
  }
  if (why != AbortCode::kNone) {
    answer = can::Abort(meaning.object, static_cast<can::SdoAbort>(why));
  }
  Queue(can::kSdoResponse, answer);
}

AbortCode Cia402Node::Write(std::uint16_t index, std::uint8_t sub, int bytes, std::uint32_t value) {
  AbortCode why = dictionary_.CheckWrite(index, sub, bytes, value);
  for (const ReceivePdo& receive : receive_) {
    if (why == AbortCode::kNone && receive.pdo.Owns(index)) {
      why = receive.pdo.CheckWrite(dictionary_, index, sub, value);
    }
  }
  for (const TransmitPdo& transmit : transmit_) {
    if (why == AbortCode::kNone && transmit.pdo.Owns(index)) {
      why = transmit.pdo.CheckWrite(dictionary_, index, sub, value);
    }
  }
  if (why == AbortCode::kNone && index == 0x6060 && value != 0 &&
      value != can::kModeCyclicVelocity) {
    why = AbortCode::kValueRange;
  }
  if (why == AbortCode::kNone && index == 0x605A && value != 2 && value != 6) {
    why = AbortCode::kValueRange;
  }
  if (why == AbortCode::kNone) {
    dictionary_.Set(index, sub, value);
    OnWritten(index, sub);
  }
  return why;
}

void Cia402Node::OnWritten(std::uint16_t index, std::uint8_t sub) {
  const std::uint32_t value = dictionary_.Value(index, sub);
  if (index == 0x6040 || index == 0x60FF) {
    ordered_ = heard_;
  }
  switch (index) {
    case 0x1003:
      for (std::uint8_t i = 1; i <= 4; ++i) {
        dictionary_.Set(0x1003, i, 0);
      }
      break;
    case 0x1016:
      host_seen_.reset();
      break;
    case 0x1017:
      next_heartbeat_.reset();
      break;
    case 0x6040: {
      const bool was_fault = drive_.state() == DriveState::kFault;
      drive_.Command(static_cast<std::uint16_t>(value));
      if (was_fault && drive_.state() != DriveState::kFault) {
        ClearErrors();
      }
      break;
    }
    case 0x605A:
      drive_.set_quick_stop_option(static_cast<QuickStopOption>(value));
      break;
    case 0x6060:
      if (value == 0 || value == can::kModeCyclicVelocity) {
        dictionary_.Set(0x6061, 0, value);
      }
      break;
    default:
      break;
  }
  for (ReceivePdo& receive : receive_) {
    if (receive.pdo.Owns(index)) {
      receive.pdo.Configure(dictionary_);
      receive.pending.reset();
      receive.applied.reset();
    }
  }
  for (TransmitPdo& transmit : transmit_) {
    if (transmit.pdo.Owns(index)) {
      transmit.pdo.Configure(dictionary_);
      transmit.sent = false;
      transmit.syncs = 0;
    }
  }
  PublishState();
}

}  // namespace pipewright::hil
