// SPDX-License-Identifier: MIT
// ArmDriver from the first frame until all drives follow.
#include <iterator>

#include "platform/drivers/arm_driver.h"

namespace pipewright {
namespace {

using can::DriveState;
using can::kArmNodes;

constexpr Duration kRequestPeriod = std::chrono::milliseconds(100);  // probes, NMT start
constexpr int kSteps = static_cast<int>(std::size(can::kArmStartup));

}  // namespace

void ArmDriver::OnSdo(Node& node, int id, const can::SdoMeaning& sdo) {
  if (phase_ == DriverPhase::kWaiting) {
    node.answered = node.answered || sdo.object == can::object::kDeviceType;
    return;
  }
  if (phase_ != DriverPhase::kConfiguring || !node.asked) {
    return;
  }
  const can::StartupStep& step = can::kArmStartup[node.step];
  if (sdo.object != step.object) {
    return;  // late, and about something else
  }
  if (sdo.kind == can::SdoKind::kAbort) {
    Fail(Status::kFault, Problem::kSetupRefused, id, sdo.value);
    return;
  }
  const std::uint32_t expected = ValueOf(step, id);
  bool right = false;
  switch (step.kind) {
    case can::StepKind::kExpect:
      right = sdo.kind == can::SdoKind::kUploadResponse && sdo.value == expected;
      break;
    case can::StepKind::kExpectBits:
      right = sdo.kind == can::SdoKind::kUploadResponse && (sdo.value & expected) == expected;
      break;
    case can::StepKind::kWrite:
      right = sdo.kind == can::SdoKind::kDownloadResponse;
      break;
  }
  if (!right) {
    Fail(Status::kFault, Problem::kWrongDevice, id, step.object.index);
    return;
  }
  ++node.step;
  node.asked = false;
}

std::uint32_t ArmDriver::ValueOf(const can::StartupStep& step, int id) const {
  return step.object == can::object::kInterpolationValue
             ? static_cast<std::uint32_t>(config_.cycle_ms)
             : step.ValueFor(id);
}

void ArmDriver::StepWaiting(Time now, TxBatch& out) {
  const bool ask = now >= next_request_;
  next_request_ = ask ? now + kRequestPeriod : next_request_;
  int missing = 0;
  for (int id = kArmNodes; id >= 1; --id) {
    if (nodes_[id - 1].answered) {
      continue;
    }
    missing = id;
    if (ask) {
      Send(Encode(can::kSdoRequest, can::UploadRequest(can::object::kDeviceType), id), out);
    }
  }
  if (missing == 0) {
    Enter(DriverPhase::kConfiguring, now);
  } else if (now - phase_start_ > config_.start_timeout) {
    Fail(Status::kTimeout, Problem::kNotHeard, missing, 0);
  }
}

void ArmDriver::StepConfiguring(Time now, TxBatch& out) {
  bool done = true;
  for (int id = 1; id <= kArmNodes && phase_ == DriverPhase::kConfiguring; ++id) {
    done = AskNext(nodes_[id - 1], id, now, out) && done;
  }
  if (done && phase_ == DriverPhase::kConfiguring) {
    for (Node& node : nodes_) {
      node.rebooted = false;
      node.operational = false;  // what it said before it was configured does not count
    }
    next_request_ = now;
    pdos_active_ = true;
    Enter(DriverPhase::kEnabling, now);
  }
}

/// Keeps one request under way. Returns whether the drive has been through all steps.
bool ArmDriver::AskNext(Node& node, int id, Time now, TxBatch& out) {
  if (node.step == kSteps) {
    return true;
  }
  const can::StartupStep& step = can::kArmStartup[node.step];
  if (node.asked && now - node.asked_at <= config_.sdo_timeout) {
    return false;
  }
  node.tries = node.asked ? node.tries + 1 : 1;
  if (node.tries > config_.sdo_tries) {
    Fail(Status::kTimeout, Problem::kSetupUnanswered, id, step.object.index);
    return false;
  }
  node.asked = true;
  node.asked_at = now;
  const can::Sdo request = step.kind == can::StepKind::kWrite
                               ? can::DownloadRequest(step.object, step.bytes, ValueOf(step, id))
                               : can::UploadRequest(step.object);
  Send(Encode(can::kSdoRequest, request, id), out);
  return false;
}

void ArmDriver::StepEnabling(Time now, TxBatch& out) {
  bool operational = true;
  int waiting_for = 0;
  std::array<std::uint32_t, kArmNodes> words{};
  for (int id = kArmNodes; id >= 1; --id) {
    const Node& node = nodes_[id - 1];
    if (node.rebooted) {
      Fail(Status::kFault, Problem::kRebooted, id, 0);
      return;
    }
    operational = operational && node.operational;
    const bool enabled = node.operational && node.drive == DriveState::kOperationEnabled &&
                         node.mode == can::kModeCyclicVelocity && node.has_feedback;
    waiting_for = enabled ? waiting_for : id;
    words[id - 1] = can::EnableWord(node.drive, node.sent_word);
  }
  if (waiting_for == 0) {
    for (Node& node : nodes_) {
      node.emergency = can::emergency::kNone;  // those before were about the past
    }
    Enter(DriverPhase::kReady, now);
  } else if (now - phase_start_ > config_.enable_timeout) {
    const Node& node = nodes_[waiting_for - 1];
    const bool fault = node.drive == DriveState::kFault;
    Fail(Status::kTimeout, fault ? Problem::kDriveFault : Problem::kNotEnabled, waiting_for,
         fault ? node.emergency : node.statusword);
    return;
  }
  if (!operational && now >= next_request_) {
    SendNmt(can::NmtCommand::kStart, out);
    next_request_ = now + kRequestPeriod;
  }
  SendWords(words, ArmVector::Zero(), out);
}

}  // namespace pipewright
