// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "platform/core/status.h"

namespace pipewright {

/// A reason that outlives the process: one line in one file, on the disk when Set() returns.
class LatchFile {
 public:
  /// @param path  empty: nothing is kept
  explicit LatchFile(std::string path = "") : path_(std::move(path)) {}

  /// The reason, cut at 200 bytes, without what a message cannot carry; empty when there is none.
  /// A file that is there but cannot be read counts as a reason.
  std::string Read() const;
  /// kUnavailable: it could not be written.
  Status Set(std::string_view reason) const;
  Status Clear() const;

  bool kept() const { return !path_.empty(); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace pipewright
