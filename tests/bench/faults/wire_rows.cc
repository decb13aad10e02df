// SPDX-License-Identifier: MIT
// F2 to F6: what a wire and a controller do to frames.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "hil/faults/wire_bits.h"
#include "platform/can/cia402.h"
#include "platform/can/tracer.h"
#include "tests/bench/faults/fault_rig.h"
#include "tests/bench/faults/rows.h"

namespace pipewright::bench {
namespace {

using std::chrono_literals::operator""ms;

bool Any(const can::Frame&) { return true; }
bool BaseState(const can::Frame& f) { return f.id == 0x211 || f.id == 0x221 || f.id == 0x311; }
bool JointFeedback(const can::Frame& f) { return 0x181 <= f.id && f.id <= 0x187; }

/// Frames lost in a row that are masked: the joints', every 10 ms, may be 50 ms old, the base's,
/// every 20 ms, 100 ms, of which the robot brakes for the second half.
constexpr int kArmBudget = 4;
constexpr int kBaseBudget = 3;

}  // namespace

Tally FramesLost(std::uint64_t n, std::uint64_t seed) {
  constexpr int kMost = 50;
  Tally tally;
  FaultRig rig(seed);
  int masked[2] = {0, 0};
  for (std::uint64_t i = 0; i < n && rig.Ready(tally); ++i) {
    const int k = 1 + static_cast<int>(i % kMost);
    const bool base = i / kMost % 2 == 1;
    rig.Begin();
    if (base) {
      rig.base().Lose(3 * k, BaseState);
    } else {
      rig.arm().Lose(kArmJoints * k, JointFeedback);
    }
    // Two more may be masked or not, by where the cycle falls among the frames.
    const int budget = base ? kBaseBudget : kArmBudget;
    const Outcome outcome = rig.Conclude(
        {.may_mask = k <= budget + 2, .window = std::max<Duration>(900ms, 20ms * (k + 1))});
    const bool was_needless = outcome == Outcome::kSafeStop && k <= budget;
    tally.Add(outcome);
    if (rig.latency()) {
      tally.latencies_ms.push_back(1e3 * ToSeconds(*rig.latency()));
    }
    if (outcome == Outcome::kMasked) {
      masked[base] = std::max(masked[base], k);
    }
    if (!rig.why().empty() || was_needless) {
      tally.Note(fmt::format("{} {} frames: {}", k, base ? "base" : "arm",
                             was_needless ? "within the budget, and yet it stopped" : rig.why()));
    }
  }
  tally.Note(fmt::format("budget: {} frames of a joint, {} of the base; most masked: {} and {}",
                         kArmBudget, kBaseBudget, masked[0], masked[1]));
  return tally;
}

Tally FramesOutOfOrder(std::uint64_t n, std::uint64_t seed) {
  Tally tally;
  FaultRig rig(seed);
  for (std::uint64_t i = 0; i < n && rig.Ready(tally); ++i) {
    hil::FaultyPort& port = rig.rng().Index(2) == 0 ? rig.base() : rig.arm();
    const int burst = 1 + rig.rng().Index(20);
    const Duration late = 1ms * (5 + rig.rng().Index(300));
    const char* what = "";
    rig.Begin();
    switch (i % 4) {
      case 0:
        what = "late";
        port.Delay(burst, late, Any);
        break;
      case 1:
        what = "duplicated";
        port.Duplicate(burst, Any);
        break;
      case 2:
        what = "swapped";
        port.Swap(rig.rng().Index(2) == 0 ? BaseState : JointFeedback);
        break;
      default:
        what = "replayed";
        for (int j = 0; j < burst; ++j) {
          port.Replay(rig.rng());
        }
        break;
    }
    // Most are masked within a cycle or two; a stop is watched to its end.
    Requirement required{.window = 120ms};
    rig.For(required.window);
    if (rig.task().report().phase != ControlPhase::kRunning || !rig.task().report().state.valid) {
      required.window = 900ms;
    }
    rig.Judge(required, what, tally);
  }
  return tally;
}

namespace {

/// Up to 8 bits of a frame of the robot's own traffic, which the controller then receives.
std::optional<can::Frame> Flipped(const can::Frame& frame, Rng& rng) {
  std::array<int, 8> at{};
  const int count = 1 + rng.Index(8);
  for (int i = 0; i < count;) {
    at[static_cast<std::size_t>(i)] = rng.Index(hil::WireBits(frame));
    i += std::find(at.begin(), at.begin() + i, at[static_cast<std::size_t>(i)]) == at.begin() + i;
  }
  return hil::ReceiveFlipped(frame, {at.data(), static_cast<std::size_t>(count)});
}

/// A frame as the robot hears it from its devices.
can::Frame Plausible(Rng& rng, bool base) {
  can::Frame frame{.dlc = 8};
  constexpr std::uint32_t kOfBase[] = {0x211, 0x221, 0x231, 0x311, 0x361};
  frame.id = base ? kOfBase[rng.Index(5)] : 0x181 + static_cast<std::uint32_t>(rng.Index(7));
  for (std::uint8_t& byte : frame.data) {
    byte = static_cast<std::uint8_t>(rng.Index(256));
  }
  return frame;
}

/// A frame that no driver may take, and the counter that must say so.
can::Frame Refused(Rng& rng, bool base, std::uint64_t can::RxCounters::*& reason) {
  can::Frame frame = Plausible(rng, base);
  switch (rng.Index(5)) {
    case 0:
      reason = &can::RxCounters::wrong_length;
      frame.dlc = static_cast<std::uint8_t>(rng.Index(8));
      break;
    case 1:
      reason = &can::RxCounters::wrong_length;
      frame.dlc = static_cast<std::uint8_t>(9 + rng.Index(7));  // the length codes of CAN FD
      break;
    case 2:
      reason = &can::RxCounters::remote;
      frame.remote = true;
      break;
    case 3:
      reason = &can::RxCounters::extended;
      frame.extended = true;
      frame.id |= static_cast<std::uint32_t>(rng.Index(1 << 18)) << 11;
      break;
    default:
      reason = &can::RxCounters::unknown_id;
      frame.id = 0x400 + static_cast<std::uint32_t>(rng.Index(0x20));
      break;
  }
  return frame;
}

const can::RxCounters& Counters(FaultRig& rig, bool base) {
  return base ? rig.task().base().rx_counters() : rig.task().arm().rx_counters();
}

using Reason = std::uint64_t can::RxCounters::*;
constexpr Reason kReasons[] = {&can::RxCounters::wrong_length, &can::RxCounters::remote,
                               &can::RxCounters::extended, &can::RxCounters::unknown_id};
constexpr const char* kReasonNames[] = {"wrong length", "remote", "extended", "unknown id"};

}  // namespace

Tally FramesDamaged(std::uint64_t n, std::uint64_t seed) {
  constexpr std::uint64_t kBatch = 1000;  // frames that are judged together
  constexpr int kPerTick = 10;
  Tally tally;
  FaultRig rig(seed);
  std::uint64_t by_checksum = 0;
  std::uint64_t passed = 0;
  std::array<std::uint64_t, 4> refused{};
  while (tally.n() < n && rig.Ready(tally)) {
    const std::uint64_t count = std::min(kBatch, n - tally.n());
    std::array<std::array<std::uint64_t, 4>, 2> expected{};
    for (const bool base : {false, true}) {
      for (std::size_t r = 0; r < 4; ++r) {
        expected[base][r] = Counters(rig, base).*kReasons[r];
      }
    }
    rig.Begin();
    for (std::uint64_t i = 0; i < count; ++i) {
      const bool base = rig.rng().Index(2) == 0;
      hil::FaultyPort& port = base ? rig.base() : rig.arm();
      if (i % 2 == 0) {
        const std::optional<can::Frame> frame = Flipped(Plausible(rig.rng(), base), rig.rng());
        (frame ? passed : by_checksum) += 1;
        if (frame) {
          port.Insert(*frame);
        }
      } else {
        Reason reason = nullptr;
        port.Insert(Refused(rig.rng(), base, reason));
        ++expected[base][static_cast<std::size_t>(
            std::find(std::begin(kReasons), std::end(kReasons), reason) - kReasons)];
      }
      if (i % kPerTick == kPerTick - 1) {
        rig.Tick();
      }
    }
    rig.For(30ms);  // all have been read
    // What passes a checksum may also be refused; a count that is too small cannot be.
    bool all = true;
    for (const bool base : {false, true}) {
      for (std::size_t r = 0; r < 4; ++r) {
        const std::uint64_t counted = Counters(rig, base).*kReasons[r];
        all = all && counted >= expected[base][r];
        refused[r] += counted - expected[base][r];
      }
    }
    const Outcome outcome = rig.Conclude({.window = 1ms * (count / kPerTick) + 40ms});
    tally.Add(all ? outcome : Outcome::kWrong, count);
    if (rig.latency()) {
      tally.latencies_ms.push_back(1e3 * ToSeconds(*rig.latency()));
    }
    if (!all) {
      tally.Note("not all that had to be refused was counted by its reason");
    } else if (!rig.why().empty()) {
      tally.Note(rig.why());
    }
  }
  tally.Note(
      fmt::format("bits flipped on the wire: {} dropped by the controller's checksum, {} passed "
                  "it and went to the drivers",
                  by_checksum, passed));
  std::string more;
  for (std::size_t r = 0; r < 4; ++r) {
    more += fmt::format("{}{} {}", r == 0 ? "" : ", ", refused[r], kReasonNames[r]);
  }
  tally.Note("refused beyond those injected for it (devices' own others, passed flips): " + more);
  return tally;
}

Tally ErrorFrames(std::uint64_t n, std::uint64_t seed) {
  struct ErrorClass {
    std::uint32_t id;
    std::uint8_t controller;  ///< byte 1
    bool stops;
    const char* name;
  };
  constexpr ErrorClass kClasses[] = {
      {0x001, 0, false, "transmit timeout"},
      {0x002, 0, false, "arbitration lost"},
      {0x004, 0x04, false, "receive warning"},
      {0x004, 0x08, false, "transmit warning"},
      {0x004, 0x10, false, "receive passive"},
      {0x004, 0x20, false, "transmit passive"},
      {0x004, 0x01, false, "receive overflow"},
      {0x008, 0, false, "protocol violation"},
      {0x010, 0, false, "transceiver"},
      {0x020, 0, false, "no acknowledge"},
      {0x080, 0, false, "bus error"},
      {0x200, 0, false, "error counters"},
      {0x040, 0, true, "bus off"},
      {0x100, 0, true, "restarted"},
  };
  Tally tally;
  FaultRig rig(seed);
  for (std::uint64_t i = 0; i < n && rig.Ready(tally); ++i) {
    const ErrorClass& c = kClasses[i % std::size(kClasses)];
    const bool base = rig.rng().Index(2) == 0;
    hil::FaultyPort& port = base ? rig.base() : rig.arm();
    can::Frame frame{.id = c.id, .dlc = 8, .error = true};
    frame.data[1] = c.controller;
    const std::uint64_t before = Counters(rig, base).error_frame;
    rig.Begin();
    port.Insert(frame);
    if (c.id == 0x040) {  // off the bus until the kernel restarts the controller
      rig.script().At(rig.bench().now() + 1ms, [&port] { port.SetDown(true); });
      rig.script().At(rig.bench().now() + 1ms * (2 + rig.rng().Index(500)),
                      [&port] { port.SetDown(false); });
    }
    // Off the bus, the base hears no more commands: its own watchdog stops it.
    const bool watchdog = c.id == 0x040;
    rig.Judge({.may_mask = !c.stops,
               .may_stop = c.stops,
               .stays = c.stops,
               .bound = watchdog ? 940ms : 700ms,
               .window = c.stops ? 1500ms : 200ms},
              c.name, tally);
    rig.For(20ms);
    if (Counters(rig, base).error_frame != before + 1) {
      tally.Add(Outcome::kWrong);
      tally.Note(fmt::format("{}: not counted", c.name));
    }
  }
  return tally;
}

Tally BusOverloaded(std::uint64_t n, std::uint64_t seed) {
  constexpr int kKinds = 6;
  constexpr const char* kNames[kKinds] = {"babbling, lowest id",   "babbling, highest id",
                                          "transmit queue full",   "transmit queue full for good",
                                          "link down for a while", "interface gone"};
  Tally tally;
  auto rig = std::make_unique<FaultRig>(seed);
  std::array<can::LoopbackBus::Port*, 2> babblers{rig->bench().Attach(0), rig->bench().Attach(1)};
  for (std::uint64_t i = 0; i < n && rig->Ready(tally); ++i) {
    const int kind = static_cast<int>(i % kKinds);
    const int wire = rig->rng().Index(2);
    hil::FaultyPort& port = wire == 0 ? rig->base() : rig->arm();
    const Duration lasts = 1ms * (5 + rig->rng().Index(600));
    const Time end = rig->bench().now() + lasts;
    const std::uint64_t failures = rig->buses().send_failures;
    const std::uint64_t refused = port.counters().tx_refused;
    rig->Begin();
    Requirement required{.bound = 940ms, .window = 1600ms};
    rig->runs = nullptr;
    switch (kind) {
      case 0:
      case 1:
        rig->runs = [&, wire, kind,
                     end] {  // each cycle: more than the wire can carry until the next
          const can::Frame junk{.id = kind == 0 ? 0x7EFU : 0x001U, .dlc = 0};
          while (rig->bench().now() < end &&
                 babblers[static_cast<std::size_t>(wire)]->Send(junk) == Status::kOk) {
          }
          return true;
        };
        break;
      case 2:
        port.SetSend(Status::kFull);
        rig->script().At(end, [&port] { port.SetSend(Status::kOk); });
        break;
      case 3:
        port.SetSend(Status::kFull);
        required.may_mask = false;
        break;
      case 4:
        port.SetDown(true);
        rig->script().At(end, [&port] { port.SetDown(false); });
        required.may_mask = lasts <= 120ms;  // the budget, of the base
        break;
      default:
        port.SetDown(true);
        required.may_mask = false;
        required.stays = true;
        break;
    }
    rig->Judge(required, kNames[kind], tally);
    rig->runs = nullptr;
    port.SetSend(Status::kOk);
    port.SetDown(false);
    if (port.counters().tx_refused - refused != rig->buses().send_failures - failures) {
      tally.Add(Outcome::kWrong);
      tally.Note(fmt::format("{}: a frame was refused and not counted", kNames[kind]));
    }
  }
  return tally;
}

}  // namespace pipewright::bench
