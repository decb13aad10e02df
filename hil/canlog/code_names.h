// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "platform/can/tracer_messages.h"

/// What the codes in frames mean, in words; the numbers themselves are platform/can's.
namespace pipewright::hil {

/// The sources differ in what 0 to 3 of base_state's control_mode mean: see ControlModeCodes.
using ControlModes = can::ControlModeCodes;

/// Writes what a code means: "operation enabled, voltage, remote"; of one without a name: its
/// number.
using AppendCode = void (*)(fmt::memory_buffer& to, std::uint32_t code, const ControlModes& modes);

/// What names the codes of this signal; null: it is a quantity, or a number such as a count.
AppendCode NamesOf(std::string_view frame, std::string_view signal);

/// A code, or a bit of one, and what it means.
struct CodeName {
  std::uint32_t code = 0;
  std::string name;
};

/// The codes of this signal that have a name, for programs that take a table of them; none of a
/// quantity, a number or a set of bits.
std::vector<CodeName> NamedCodes(std::string_view frame, std::string_view signal,
                                 const ControlModes& modes);
/// The bits of this signal that have a name; none if it is no set of bits.
std::vector<CodeName> NamedBits(std::string_view frame, std::string_view signal);

void AppendText(fmt::memory_buffer& to, std::string_view text);
/// "heartbeat lost (0x8130)".
void AppendEmergency(fmt::memory_buffer& to, std::uint32_t code);

}  // namespace pipewright::hil
