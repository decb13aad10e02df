// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <map>

#include "platform/core/time.h"

namespace pipewright::hil {

/// What is to go wrong, and when: actions at instants, done in their order.
///
///   FaultScript script;
///   script.At(now + 1s, [&] { devices.tracer().PressEmergencyStop(true); });
///   script.At(now + 2s, [&] { devices.tracer().PressEmergencyStop(false); });
///   ... script.AdvanceTo(now);                                              // each tick
class FaultScript {
 public:
  void At(Time when, std::function<void()> action) { actions_.emplace(when, std::move(action)); }

  /// Does all that is due. An action may add more.
  void AdvanceTo(Time now);

  bool done() const { return actions_.empty(); }

 private:
  std::multimap<Time, std::function<void()>> actions_;
};

}  // namespace pipewright::hil
