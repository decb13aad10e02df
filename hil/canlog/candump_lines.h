// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "hil/canlog/channel_names.h"
#include "hil/canlog/line_meaning.h"
#include "hil/canlog/log_frame.h"

/// The two texts of can-utils' candump, a line a frame.
namespace pipewright::hil {

/// `candump -L`, and the files that `candump -l` writes:
///
///   (1699000000.123456) can0 123#DEADBEEF          11-bit id; 6 or 9 decimals
///   (1699000000.123456) can0 12345678#             29-bit id, no payload
///   (1699000000.123456) can0 123#R8                remote, for 8 bytes
///   (1699000000.123456) can0 123##1DEADBEEF        CAN FD; flags: 1 bit rate switch, 2 ESI
///   (1699000000.123456) can0 20000080#0000000000000000   error message
///
/// The length code of a classic frame with 8 bytes (`_9` to `_F`) and whatever follows a frame are
/// let pass; ` R` and ` T` tell the direction. Lines that begin with '#' are comments.
LineMeaning ReadCandumpLogLine(std::string_view line, ChannelNames& channels, LogFrame& frame);

/// candump's own output, on a terminal or into a file:
///
///     can0  123   [8]  DE AD BE EF 00 11 22 33
///    (1699000000.123456)  can0  123   [4]  DE AD BE EF   '....'      -t a, with -a
///    (2023-11-03 09:26:40.123456)  can0  12345678   [0]              -t A, taken for UTC
///    (003.000125)  can0  TX B -  123  [12]  00 01 ..                 -t z or -t d; -x; CAN FD
///     can0  123   [8]  remote request
///     can0  20000080   [8]  00 00 00 00 00 00 00 00   ERRORFRAME
///
/// Payloads in binary (-i) and in reverse (-S) are not read. -t d gives times between frames: the
/// stamp is what the line says.
LineMeaning ReadCandumpLine(std::string_view line, ChannelNames& channels, LogFrame& frame);

}  // namespace pipewright::hil
