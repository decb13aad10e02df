// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "tests/perception/map/map_data.h"

namespace pipewright::bench {

/// What both maps are given.
struct MapScene {
  std::string name;
  std::vector<test::Scan> scans;
  std::vector<test::View> views;
  MapConfig config;
};

/// `cube` and `office` of $PIPEWRIGHT_SHARED/data/map; without it a cube with three pipes, made up.
std::vector<MapScene> MapScenes();

}  // namespace pipewright::bench
