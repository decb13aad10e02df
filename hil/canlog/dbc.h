// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "hil/canlog/code_names.h"

namespace pipewright::hil {

/// Whose frames a DBC file is to hold: one bus each, or both of them on a shared one.
enum class DbcDevices : std::uint8_t { kTracer, kArm, kBoth };

/// The tables of platform/can as a DBC file, for SavvyCAN, CANoe, Wireshark, Kvaser's tools and the
/// like. A frame that several nodes send is a message for each, "tpdo1_joint_feedback_3"; of
/// heartbeats those of the arm's nodes and of the host. Codes have value tables; a set of bits has
/// its bits in the comment, for a DBC file has no other place for them. SDOs are raw: which object
/// they carry is told by index and subindex.
///
/// A frame that has two lengths has the one that is sent.
std::string DbcText(DbcDevices devices, const ControlModes& modes);

}  // namespace pipewright::hil
