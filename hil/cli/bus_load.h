// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace pipewright::hil {

/// The most that a bus may be filled, so that what must be in time finds its gap.
inline constexpr double kBusLoadLimit = 0.7;

/// Bits of a frame with an 11-bit id and n payload bytes, with the most stuff bits that any content
/// can cause, and the interframe space:  47 + 8 n + floor((34 + 8 n - 1) / 4).
int WorstFrameBits(int payload_bytes);

/// The share of a wire that the base's periodic frames take, commands included; worst case.
double BaseLoad(int bitrate);

/// The same of the arm: SYNC, a command and feedback of each joint every cycle, status and
/// heartbeats at their own rates.
double ArmLoad(double cycle_hz, int bitrate);

/// Why base and arm do not fit their wires at this rate, in words; empty if they do.
/// @param shared  one wire at the base's bitrate, else the arm has its own
std::string LoadError(double cycle_hz, bool shared);

}  // namespace pipewright::hil
