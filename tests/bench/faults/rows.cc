// SPDX-License-Identifier: MIT
#include "tests/bench/faults/rows.h"

namespace pipewright::bench {
namespace {

constexpr Row kRows[] = {
    {"F1", "program killed, or stopped, in motion",
     "half are killed; half get no cycle for 0.6 to 2 s and then go on: they must not move before "
     "they are re-armed. S: the base's watchdog acts within 500 ms and brakes from 0.4 m/s at "
     "1 m/s^2: standstill within 920 ms",
     200, ProgramDies},
    {"F2", "k = 1..50 state frames lost",
     "all of the base's or all of a joint's. M up to 4 frames of the joints or 3 of the base, M or "
     "S up to two more, beyond that S",
     5000, FramesLost},
    {"F3", "frames late, twice, swapped, replayed",
     "by turns, up to 20 at a time, late by 5 to 305 ms; a replayed one is stamped anew. M or S",
     10000, FramesOutOfOrder},
    {"F4", "damaged and foreign frames",
     "half: 1 to 8 bits of a frame flipped on the wire, where the controller's checksum drops it "
     "or, rarely, lets it pass to the drivers; half: wrong length, FD's length codes, remote, "
     "29-bit and unknown ids, each of which must be counted by its reason. M or S; judged by the "
     "thousand",
     1000000, FramesDamaged},
    {"F5", "error frames of every class",
     "bus-off and restart: S, and at rest until re-armed; all others: M, and counted", 1400,
     ErrorFrames},
    {"F6", "babbling, full queues, link down, gone",
     "six kinds by turns, for 5 to 605 ms or for good. M or S within 940 ms: the devices' "
     "watchdogs stop what no command reaches. Each frame refused is counted",
     600, BusOverloaded},
    {"F7", "numbers that are none, or odd",
     "NaN, infinities, denormals, 1e300, the largest: in each number of the control task's "
     "configuration (S: refused at start, nothing moves) and in goals, planes, pipes and pose "
     "fixes "
     "of a robot that moves (M or S)",
     2000, OddNumbers},
    {"F8", "QPs infeasible, degenerate, capped",
     "law and envelope in random places among up to 32 primitives, some twice or against "
     "themselves, and 40 obstacles, ten cycles each; half with one round a cycle. S: u is zero",
     100000, HardQps},
    {"F9", "cycles that overrun by 1 to 10 periods",
     "1 to 4 in a row: M or S, each counted; for good: S after the fifth", 1000, CyclesOverrun},
    {"F10", "clocks stepped",
     "by turns: stamps an hour ahead, an hour behind; the clock of stamps and program jumps ahead "
     "or back by 10 to 2010 ms. Ahead M or S; back by 60 ms or more S",
     100, ClocksStepped},
    {"F11", "covariances not true",
     "of planes and pipes: zero, or with a negative variance (S: Sound() refuses them); "
     "understated "
     "tenfold (M: taken), with the rate at which points on their row then violate it",
     10000, WrongCovariances},
    {"F12", "stores full",
     "by turns: bricks of the map, primitives, patches to cover, nodes of a tree. M: said and "
     "counted, what is held stays right, and what comes next goes on",
     400, StoresFull},
    {"F13", "emergency stop pressed, EMCY",
     "the button for 20 to 1020 ms; EMCY of a drive at fault; EMCY that is over before the next "
     "cycle. S, at rest until re-armed",
     200, EmergencyStops},
    {"F14", "logs cut and flipped at every byte",
     "24 frames in every format that canlog reads. M: of a cut one the beginning of the whole; of "
     "a "
     "flipped one its end, and no more than one frame more",
     1000000, LogsDamaged},
    {"F15", "configurations that make no sense",
     "each key of the daemon's and of a scenario: another in its place, twice, of another type, no "
     "number; and those that contradict others. S: refused with file and line",
     1000000, BadConfigurations},
    {"F16", "cycles that take memory",
     "control cycles with frames lost and replayed; all other rows' cycles are watched likewise. "
     "M: "
     "nothing was taken from the heap",
     50000, CyclesThatAllocate},
    {"F17", "camera and floor at fault (F17, F18)",
     "whole missions with --faults rough: depth noise and lost frames, slip, yaw scale, a spill. M "
     "complete, S ended otherwise, W a contact",
     3, MissionsUnderFaults},
};

}  // namespace

std::span<const Row> Rows() { return kRows; }

}  // namespace pipewright::bench
