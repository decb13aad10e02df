// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "hil/canlog/id_table.h"
#include "hil/canlog/log_frame.h"
#include "platform/can/sdo.h"

namespace pipewright::hil {

enum class FindingKind : std::uint8_t {
  kGap,             ///< a periodic id was silent for too long
  kDuplicate,       ///< the same bytes again, far sooner than the id's period
  kCountJump,       ///< a rolling count left numbers out
  kCountRepeat,     ///< one that has moved before stood still
  kCountBack,       ///< one went back
  kCommandExpired,  ///< the base's command watchdog ran out: it stops by itself
  kHeartbeatLost,
  kRestart,       ///< a node booted up after it had been running
  kEmergency,     ///< an EMCY other than "no error any more"
  kErrorMessage,  ///< of the controller
  kSdoUnanswered,
  kSdoAborted,
  kTimeBack,       ///< a stamp is below that of the frame before, on one channel
  kSdoBeforeBoot,  ///< unanswered, by a node not heard of before: a note
};
inline constexpr int kFindingKinds = 14;

/// Whether a finding is worth knowing and no fault: a host that is up before its nodes asks until
/// one answers.
constexpr bool IsNote(FindingKind kind) { return kind == FindingKind::kSdoBeforeBoot; }

/// "gap", "count_jump" ...
const char* Name(FindingKind kind);

struct Finding {
  FindingKind kind = FindingKind::kGap;
  std::int64_t at_ns = 0;  ///< of the frame that shows it, or the log's end
  IdKey key;
  double seconds = 0;      ///< of silence; since the frame before; waited for an answer
  double expected_s = 0;   ///< of a gap, a duplicate: the id's period
  std::uint32_t code = 0;  ///< EMCY code; abort code; frames that a count left out; 1: moving, or
                           ///< of an SDO unanswered: the node was never heard of
  can::Object object;      ///< of an SDO
  const LogFrame* frame = nullptr;  ///< of an error message
};

struct WatchConfig {
  double gap_factor = 3;                  ///< a gap is longer than so many periods
  double duplicate_part = 0.2;            ///< a duplicate comes within this part of a period
  std::int64_t duplicate_ns = 1'000'000;  ///< or of this time, of an id without a period
  std::int64_t sdo_timeout_ns = 1'000'000'000;
};

/// Looks for what should not be in a log. Periods, counts and watchdogs are those of the tables;
/// of an id that is in none, the first kLearn times between its frames tell whether it is periodic:
/// when all of them are within a factor of two of their median.
///
/// Memory: kMost ids of IdTable; frames of others are not watched and counted.
class LogWatch {
 public:
  using Report = std::function<void(const Finding&)>;
  static constexpr int kLearn = 16;

  LogWatch(const WatchConfig& config, Report report)
      : config_(config), report_(std::move(report)) {}

  void Add(std::span<const LogFrame> frames);
  /// Tells what was silent, or not answered, when the log ended.
  void End();

  std::uint64_t not_watched() const { return not_watched_; }

 private:
  struct IdState {
    bool seen = false;
    bool stamped = false;
    std::int64_t last_ns = 0;
    std::int64_t period_ns = 0;  ///< 0: none, or not known yet
    int learned = 0;
    std::array<std::int64_t, kLearn> times{};
    std::uint64_t payload = 0;
    std::uint8_t length = 0;
    bool count_moved = false;
    bool moving = false;    ///< a command: it asks for speed
    bool running = false;   ///< a heartbeat other than boot-up was seen
    bool sdo_open = false;  ///< a request waits for its answer
    bool sdo_to_unheard = false;
    std::int64_t sdo_since_ns = 0;  ///< of those to a node not heard of: the first
    can::Object sdo_object;
  };

  void Watch(const LogFrame& frame, IdState& state);
  void WatchTime(const LogFrame& frame, IdState& state);
  void WatchSilence(const IdKey& key, const IdState& state, std::int64_t now_ns);
  void WatchCount(const LogFrame& frame, IdState& state, int byte);
  void WatchMeaning(const LogFrame& frame, IdState& state);
  void SdoRequest(const LogFrame& frame, IdState& state);
  void SdoResponse(const LogFrame& frame);
  void Learn(std::int64_t time_ns, IdState& state) const;
  bool Heard(const IdKey& sdo_request) const;

  WatchConfig config_;
  Report report_;
  IdTable<IdState> ids_;
  std::array<std::int64_t, 256> last_of_channel_{};
  std::array<bool, 256> channel_seen_{};
  std::array<std::bitset<128>, 256> heard_{};  ///< nodes that have sent something, by channel
  std::uint64_t not_watched_ = 0;
};

}  // namespace pipewright::hil
