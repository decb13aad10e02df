// SPDX-License-Identifier: MIT
#pragma once

#include "perception/scene.h"

namespace pipewright {

class DistanceField;
class VoxelGrid;

/// What a configuration is checked against. The three are of the same instant and outlive this.
struct Surroundings {
  const DistanceField& field;
  const VoxelGrid& map;
  const Scene& scene;
};

}  // namespace pipewright
