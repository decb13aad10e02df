// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "platform/core/depth_frame.h"
#include "platform/core/status.h"

namespace pipewright {

/// The service's way to the camera. Never waits.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// The next frame, its stamp on the clock of Now(). kTimeout: none yet. kUnavailable: there is no
  /// camera now, error_text() says why; it is looked for again by itself. `frame` may be written in
  /// any case.
  virtual Status Poll(Time now, DepthFrame& frame) = 0;
  virtual std::string_view error_text() const = 0;
};

/// Any camera of platform/linux.
template <typename Camera>
class FrameSourceOf final : public FrameSource {
 public:
  explicit FrameSourceOf(Camera& camera) : camera_(camera) {}
  Status Poll(Time now, DepthFrame& frame) override { return camera_.Poll(now, frame); }
  std::string_view error_text() const override { return camera_.error_text(); }

 private:
  Camera& camera_;
};

}  // namespace pipewright
