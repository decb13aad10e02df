// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "hil/devices/cia402_node.h"

namespace pipewright::hil {

/// The factory state of a drive's dictionary: CiA 301 and CiA 402 entries with their defaults, and
/// the PDO records. Every PDO is off but TPDO2, as the recorded drive's.
ObjectDictionary FactoryDictionary(const Cia402Config& config,
                                   const std::vector<ReceivePdo>& receive,
                                   const std::vector<TransmitPdo>& transmit);

/// Limits as the dictionary now has them, in SI.
DriveLimits LimitsOf(const ObjectDictionary& dictionary);

}  // namespace pipewright::hil
