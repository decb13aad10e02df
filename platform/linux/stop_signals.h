// SPDX-License-Identifier: MIT
#pragma once

namespace pipewright {

/// SIGTERM and SIGINT as a question to be asked, not as an interruption. Call Block() before the
/// first thread starts: threads inherit it.
class StopSignals {
 public:
  static void Block();
  /// Whether one has come since the last call. Never waits.
  static bool Pending();
};

}  // namespace pipewright
