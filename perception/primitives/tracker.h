// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "perception/cloud/cloud.h"
#include "perception/scene.h"

namespace pipewright {

struct PrimitiveConfig {};

class PrimitiveTracker {
 public:
  PrimitiveTracker(const PrimitiveConfig&, std::uint64_t) {}
  void Step(const Cloud& cloud) { scene_.stamp = cloud.stamp; }
  const Scene& scene() const { return scene_; }

 private:
  Scene scene_;
};

}  // namespace pipewright
