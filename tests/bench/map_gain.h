// SPDX-License-Identifier: MIT
#pragma once

#include "tests/bench/map_scenes.h"

namespace pipewright::bench {

/// What the planner's GainEvaluator takes for one view of 200 camera and 200 probe rays, each voxel
/// counted once, on the scene's map; nobody to compare with. [us]
double TimeGain(const MapScene& scene, int passes);

}  // namespace pipewright::bench
