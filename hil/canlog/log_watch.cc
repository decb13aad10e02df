// SPDX-License-Identifier: MIT
#include "hil/canlog/log_watch.h"

#include <algorithm>
#include <cstring>

#include "hil/canlog/frame_rows.h"
#include "platform/can/arm_startup.h"

namespace pipewright::hil {
namespace {

constexpr std::uint32_t kCommandId = can::kBaseTwistCommand.head.id;
constexpr std::int64_t kCommandTimeout_ns = can::kTracerCommandTimeout.count();
constexpr std::int64_t kHeartbeatTimeout_ns = can::kHostHeartbeatTimeout_ms * 1'000'000LL;

double Seconds(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

/// The payload byte with each row's rolling count; -1: it has none.
constexpr auto kCountByte = std::apply(
    [](const auto&... row) {
      const auto byte_of = [](const auto& one) {
        int byte = -1;
        for (const auto& signal : one.signals) {
          byte = signal.name == "count" ? signal.start / 8 : byte;
        }
        return byte;
      };
      return std::array{byte_of(row)...};
    },
    kLogTable);

bool IsRow(const LogFrame& frame, const can::FrameHead& head) {
  return RowOf(frame) >= 0 && can::NodeOf(head, frame.id) >= 0;
}

std::uint64_t FirstBytes(const LogFrame& frame) {
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, frame.data.data(), sizeof bytes);
  return bytes;
}

Finding Of(FindingKind kind, const LogFrame& frame) {
  return {.kind = kind, .at_ns = frame.stamp_ns, .key = KeyOf(frame), .object = {}};
}

}  // namespace

const char* Name(FindingKind kind) {
  constexpr const char* kNames[] = {
      "gap",        "duplicate",       "count_jump",     "count_repeat",
      "count_back", "command_expired", "heartbeat_lost", "restart",
      "emergency",  "error_message",   "sdo_unanswered", "sdo_aborted",
      "time_back",  "sdo_before_boot",
  };
  static_assert(std::size(kNames) == kFindingKinds);
  return kNames[static_cast<int>(kind)];
}

void LogWatch::Add(std::span<const LogFrame> frames) {
  for (const LogFrame& frame : frames) {
    if (frame.error) {
      Finding finding = Of(FindingKind::kErrorMessage, frame);
      finding.frame = &frame;
      report_(finding);
      continue;
    }
    std::int64_t& last = last_of_channel_[frame.channel];
    if (frame.stamped && channel_seen_[frame.channel] && frame.stamp_ns < last) {
      Finding finding = Of(FindingKind::kTimeBack, frame);
      finding.seconds = Seconds(last - frame.stamp_ns);
      report_(finding);
    }
    channel_seen_[frame.channel] = channel_seen_[frame.channel] || frame.stamped;
    last = frame.stamped ? frame.stamp_ns : last;
    IdState* const state = ids_.Find(KeyOf(frame));
    if (state != nullptr) {
      Watch(frame, *state);
    } else {
      ++not_watched_;
    }
    if (IsRow(frame, can::kSdoResponse.head)) {
      SdoResponse(frame);  // looks another id up: `state` may be gone
    }
  }
}

void LogWatch::Watch(const LogFrame& frame, IdState& state) {
  const int row = RowOf(frame);
  if (!state.seen && row >= 0) {
    state.period_ns = kLogHeads[static_cast<std::size_t>(row)].period.count();
    state.learned = kLearn;
  }
  if (frame.stamped) {
    if (state.stamped) {
      WatchTime(frame, state);
    }
    state.stamped = true;
  }
  const int count_byte = row >= 0 ? kCountByte[static_cast<std::size_t>(row)] : -1;
  if (count_byte >= 0 && frame.payload_bytes() > count_byte) {
    WatchCount(frame, state, count_byte);
  }
  if (row >= 0) {
    const can::FrameHead& head = kLogHeads[static_cast<std::size_t>(row)];
    if (head.direction == can::Direction::kFromDevice) {
      heard_[frame.channel].set(static_cast<std::size_t>(can::NodeOf(head, frame.id)));
    }
    WatchMeaning(frame, state);
  }
  state.last_ns = frame.stamped ? frame.stamp_ns : state.last_ns;
  state.payload = FirstBytes(frame);
  state.length = frame.length;
  state.seen = true;
}

void LogWatch::WatchTime(const LogFrame& frame, IdState& state) {
  const std::int64_t time_ns = frame.stamp_ns - state.last_ns;
  WatchSilence(KeyOf(frame), state, frame.stamp_ns);
  const double soon_ns = state.period_ns > 0
                             ? config_.duplicate_part * static_cast<double>(state.period_ns)
                             : static_cast<double>(config_.duplicate_ns);
  const bool same = frame.length == state.length && FirstBytes(frame) == state.payload;
  // Without a payload, or of more than 8 bytes, being the same says nothing.
  if (same && frame.payload_bytes() > 0 && !frame.fd && time_ns >= 0 &&
      static_cast<double>(time_ns) < soon_ns) {
    Finding finding = Of(FindingKind::kDuplicate, frame);
    finding.seconds = Seconds(time_ns);
    finding.expected_s = Seconds(state.period_ns);
    report_(finding);
  }
  Learn(time_ns, state);
}

void LogWatch::Learn(std::int64_t time_ns, IdState& state) const {
  if (state.learned == kLearn) {
    return;
  }
  state.times[static_cast<std::size_t>(state.learned++)] = time_ns;
  if (state.learned == kLearn) {
    std::sort(state.times.begin(), state.times.end());
    const std::int64_t median = state.times[kLearn / 2];
    const bool periodic = 2 * state.times.front() >= median && state.times.back() <= 2 * median;
    state.period_ns = periodic ? median : 0;
  }
}

void LogWatch::WatchSilence(const IdKey& key, const IdState& state, std::int64_t now_ns) {
  const std::int64_t silent_ns = now_ns - state.last_ns;
  Finding finding{.kind = FindingKind::kGap,
                  .at_ns = now_ns,
                  .key = key,
                  .seconds = Seconds(silent_ns),
                  .expected_s = Seconds(state.period_ns),
                  .object = {}};
  const int row = RowOf(key.id, key.extended, key.error);
  if (row >= 0 && can::NodeOf(can::kHeartbeat.head, key.id) >= 0) {
    if (silent_ns > kHeartbeatTimeout_ns) {
      finding.kind = FindingKind::kHeartbeatLost;
      report_(finding);
    }
    return;
  }
  if (row >= 0 && key.id == kCommandId && silent_ns > kCommandTimeout_ns) {
    finding.kind = FindingKind::kCommandExpired;
    finding.code = state.moving ? 1 : 0;
    report_(finding);
  } else if (state.period_ns > 0 && static_cast<double>(silent_ns) >
                                        config_.gap_factor * static_cast<double>(state.period_ns)) {
    report_(finding);
  }
}

void LogWatch::WatchCount(const LogFrame& frame, IdState& state, int byte) {
  const std::uint32_t count = frame.data[static_cast<std::size_t>(byte)];
  const std::uint32_t before = static_cast<std::uint32_t>(state.payload >> 8 * byte) & 0xFF;
  const std::uint32_t step = (count - before) & 0xFF;
  if (!state.seen || step == 1) {
    state.count_moved = state.count_moved || state.seen;
    return;
  }
  Finding finding = Of(step == 0    ? FindingKind::kCountRepeat
                       : step < 128 ? FindingKind::kCountJump
                                    : FindingKind::kCountBack,
                       frame);
  finding.code = step == 0 ? 0 : step < 128 ? step - 1 : 256 - step;
  finding.seconds = Seconds(frame.stamp_ns - state.last_ns);
  if (step != 0 || state.count_moved) {  // some hosts send 0 for ever
    report_(finding);
  }
  state.count_moved = state.count_moved || step != 0;
}

void LogWatch::WatchMeaning(const LogFrame& frame, IdState& state) {
  const can::Frame classic = ClassicFrame(frame);
  if (frame.id == kCommandId) {
    const auto command = can::Decode(can::kBaseTwistCommand, classic);
    state.moving = command.ok() && (command->v_mps != 0 || command->omega_radps != 0);
  } else if (IsRow(frame, can::kHeartbeat.head)) {
    const auto heartbeat = can::Decode(can::kHeartbeat, classic);
    const bool booted =
        heartbeat.ok() && heartbeat->state == static_cast<std::uint32_t>(can::NmtState::kBootUp);
    if (booted && state.running) {
      report_(Of(FindingKind::kRestart, frame));
    }
    state.running = heartbeat.ok() && !booted;
  } else if (IsRow(frame, can::kEmergency.head)) {
    const auto emergency = can::Decode(can::kEmergency, classic);
    if (emergency.ok() && emergency->code != can::emergency::kNone) {
      Finding finding = Of(FindingKind::kEmergency, frame);
      finding.code = emergency->code;
      report_(finding);
    }
  } else if (IsRow(frame, can::kSdoRequest.head)) {
    SdoRequest(frame, state);
  }
}

void LogWatch::SdoRequest(const LogFrame& frame, IdState& state) {
  const auto sdo = can::Decode(can::kSdoRequest, ClassicFrame(frame));
  if (!sdo.ok()) {
    return;
  }
  if (state.sdo_open) {
    Finding finding =
        Of(state.sdo_to_unheard ? FindingKind::kSdoBeforeBoot : FindingKind::kSdoUnanswered, frame);
    finding.seconds = Seconds(frame.stamp_ns - state.last_ns);
    finding.object = state.sdo_object;
    report_(finding);
  }
  const can::SdoMeaning meaning = can::Meaning(*sdo, /*from_server=*/false);
  state.sdo_open = meaning.kind != can::SdoKind::kAbort;  // an abort ends a transfer
  state.sdo_object = meaning.object;
  const bool unheard = !Heard(KeyOf(frame));
  state.sdo_since_ns = unheard && state.sdo_to_unheard ? state.sdo_since_ns : frame.stamp_ns;
  state.sdo_to_unheard = unheard;
}

bool LogWatch::Heard(const IdKey& sdo_request) const {
  return heard_[sdo_request.channel].test(
      static_cast<std::size_t>(can::NodeOf(can::kSdoRequest.head, sdo_request.id)));
}

void LogWatch::SdoResponse(const LogFrame& frame) {
  const auto sdo = can::Decode(can::kSdoResponse, ClassicFrame(frame));
  const int node = can::NodeOf(can::kSdoResponse.head, frame.id);
  IdState* const request = ids_.Find(
      {frame.channel, false, false, can::kSdoRequest.head.id + static_cast<std::uint32_t>(node)});
  if (!sdo.ok() || request == nullptr) {
    return;
  }
  const can::SdoMeaning meaning = can::Meaning(*sdo, /*from_server=*/true);
  Finding finding = Of(FindingKind::kSdoAborted, frame);
  finding.seconds = Seconds(frame.stamp_ns - request->last_ns);
  finding.object = meaning.object;
  finding.code = meaning.value;
  if (meaning.kind == can::SdoKind::kAbort) {
    report_(finding);
  } else if (request->sdo_open && frame.stamped &&
             frame.stamp_ns - request->last_ns > config_.sdo_timeout_ns) {
    finding.kind = FindingKind::kSdoUnanswered;
    report_(finding);
  }
  request->sdo_open = false;
}

void LogWatch::End() {
  for (const auto& [key, state] : ids_.entries()) {
    const std::int64_t end_ns = last_of_channel_[key.channel];
    if (state.stamped) {
      WatchSilence(key, state, end_ns);
    }
    if (state.sdo_open && end_ns - state.sdo_since_ns > config_.sdo_timeout_ns) {
      report_({.kind = FindingKind::kSdoUnanswered,
               .at_ns = end_ns,
               .key = key,
               .seconds = Seconds(end_ns - state.sdo_since_ns),
               .code = Heard(key) ? 0U : 1U,
               .object = state.sdo_object});
    }
  }
}

}  // namespace pipewright::hil
