// SPDX-License-Identifier: MIT
#pragma once

#include <concepts>

#include "platform/can/frame.h"
#include "platform/core/status.h"

namespace pipewright::can {

/// One node's access to a bus. Neither call waits.
///
///   Send     kOk: queued. kFull: the transmit queue is full, the frame is dropped and counted.
///            kUnavailable: bus off or interface gone.
///   Receive  true: frame holds the oldest frame not yet read; its stamp is set.
template <typename B>
concept Bus = requires(B& bus, const Frame& tx, Frame& rx) {
  { bus.Send(tx) } -> std::same_as<Status>;
  { bus.Receive(rx) } -> std::same_as<bool>;
};

}  // namespace pipewright::can
