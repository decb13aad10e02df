// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string_view>

#include "hil/canlog/channel_names.h"
#include "hil/canlog/line_meaning.h"
#include "hil/canlog/line_scanner.h"
#include "hil/canlog/log_frame.h"

namespace pipewright::hil {

/// Vector's ASC text:
///
///   date Fri Nov 3 09:26:40.000 am 2023            not used: stamps count from the measurement's
///   start base hex  timestamps absolute                  or dec, or relative: to the event before
///   // a comment
///   Begin Triggerblock Fri Nov 3 09:26:40.000 am 2023
///      0.000000 Start of measurement
///      0.015991 1  123             Rx   d 8 01 A0 0F A6 60 3B D1 40  Length = 273910 BitCount =
///      141 0.020000 1  12345678x       Tx   r 8           29-bit id, remote 0.030000 2  ErrorFrame
///      ECC: 10100010 0.040000 CANFD   3 Rx        300  Name  1 0 8  8 01 02 03 04 05 06 07 08
///      102203  133   303000
///                                              BRS, ESI, length code, length;  duration, bits,
///                                              flags
///   End TriggerBlock
///
/// An ErrorFrame becomes an error message of class 0x80 (bus error) with 8 bytes of 0, as
/// can-utils' asc2log has it. Requests to send (TxRq) and events of other kinds are passed over.
class AscLines {
 public:
  LineMeaning Read(std::string_view line, ChannelNames& channels, LogFrame& frame);

 private:
  bool TakeHeader(std::string_view line);
  LineMeaning TakeClassic(LineScanner& in, LogFrame& frame) const;
  LineMeaning TakeFd(LineScanner& in, ChannelNames& channels, LogFrame& frame) const;
  /// What follows the id.
  LineMeaning TakeFdPayload(LineScanner& in, LogFrame& frame) const;
  bool TakeId(std::string_view word, LogFrame& frame) const;
  bool TakePayload(LineScanner& in, LogFrame& frame) const;
  int Number(LineScanner& in, int digits, std::uint64_t& value) const;

  bool decimal_ = false;
  bool relative_ = false;
  std::int64_t last_ns_ = 0;
};

}  // namespace pipewright::hil
