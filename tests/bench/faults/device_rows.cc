// SPDX-License-Identifier: MIT
// F1 and F13: the program is gone, or somebody presses the button.
#include <array>

#include "platform/can/cia402.h"
#include "tests/bench/faults/fault_rig.h"
#include "tests/bench/faults/rows.h"

namespace pipewright::bench {
namespace {

using std::chrono_literals::operator""ms;

/// The base's watchdog acts 500 ms after its last command; then it brakes from 0.4 m/s at 1 m/s^2.
constexpr Duration kWatchdogStandstill = 500ms + 400ms + 20ms;

}  // namespace

Tally ProgramDies(std::uint64_t n, std::uint64_t seed) {
  Tally tally;
  FaultRig rig(seed);
  for (std::uint64_t i = 0; i < n; ++i) {
    if (!rig.Ready(tally)) {
      continue;
    }
    const bool killed = i % 2 == 0;
    const Time back = rig.bench().now() + 1ms * (600 + rig.rng().Index(1400));
    const int trips = rig.bench().devices().tracer().watchdog_trips();
    bool tripped = false;
    rig.runs = [&] {
      if (!tripped && rig.bench().devices().tracer().watchdog_trips() > trips) {
        tripped = true;
        rig.Detected();
      }
      return !killed && rig.bench().now() >= back;
    };
    rig.Begin();
    // A program that goes on again must not move before it is re-armed: its drives are at fault.
    rig.Judge({.may_mask = false, .stays = true, .bound = kWatchdogStandstill, .window = 2500ms},
              killed ? "killed" : "stopped and continued", tally);
    rig.runs = nullptr;
    if (killed && rig.latency() && *rig.latency() > 510ms) {
      tally.Note("the base's watchdog acted late");
    }
  }
  return tally;
}

Tally EmergencyStops(std::uint64_t n, std::uint64_t seed) {
  Tally tally;
  FaultRig rig(seed);
  for (std::uint64_t i = 0; i < n; ++i) {
    if (!rig.Ready(tally)) {
      continue;
    }
    rig.Begin();
    const Time now = rig.bench().now();
    std::string what;
    if (i % 2 == 0) {
      // 0x211 goes out every 20 ms: what is pressed for less need not be in any.
      const int ms = 20 + rig.rng().Index(1000);
      what = "button for " + std::to_string(ms) + " ms";
      rig.bench().devices().tracer().PressEmergencyStop(true);
      rig.script().At(now + 1ms * ms,
                      [&] { rig.bench().devices().tracer().PressEmergencyStop(false); });
    } else {
      const int joint = rig.rng().Index(kArmJoints);
      what = "EMCY of joint " + std::to_string(joint + 1);
      if (i % 4 == 1) {
        rig.bench().devices().joint(joint).RaiseInternalFault(0x2310);
        rig.script().At(now + 1ms * rig.rng().Index(300),
                        [&, joint] { rig.bench().devices().joint(joint).ClearInternalFault(); });
      } else {  // and at once, before any cycle, that it is over
        for (const std::uint32_t code : {0x8130U, 0U}) {
          rig.arm().Insert(*can::Encode(can::kEmergency, {.code = code}, joint + 1));
        }
        what += ", over at once";
      }
    }
    rig.Judge({.may_mask = false, .stays = true, .window = 1500ms}, what, tally);
  }
  return tally;
}

}  // namespace pipewright::bench
