// SPDX-License-Identifier: MIT
#include "tests/bench/map_scenes.h"

#include <algorithm>
#include <cmath>

#include "platform/core/rng.h"

namespace pipewright::bench {
namespace {

using test::Scan;

// 19,200 readings of the inside of [0, 1.5]^3 m and of three pipes along x, y and z.
Scan LookIntoCube(Rng* rng) {
  Scan scan;
  const Vector3d o(rng->Uniform(0.2, 0.5), rng->Uniform(0.2, 1.3), rng->Uniform(0.2, 1.3));
  scan.origin_W = o.cast<float>();
  for (int n = 0; n < 19200; ++n) {
    const Vector3d d(1, rng->Uniform(-0.6, 0.6), rng->Uniform(-0.45, 0.45));
    double reach = 1e9;
    for (int i = 0; i < 3; ++i) {
      reach = std::min(reach, ((d[i] > 0 ? 1.5 : 0.0) - o[i]) / d[i]);
      const int j = (i + 1) % 3;
      const int k = (i + 2) % 3;
      const double a = d[j] * d[j] + d[k] * d[k];
      const double b = d[j] * (o[j] - 1.0) + d[k] * (o[k] - 0.7);
      const double c = (o[j] - 1.0) * (o[j] - 1.0) + (o[k] - 0.7) * (o[k] - 0.7) - 0.06 * 0.06;
      if (b * b > a * c && b < 0 && c > 0) {
        reach = std::min(reach, (-b - std::sqrt(b * b - a * c)) / a);
      }
    }
    scan.points_W.emplace_back((o + d * reach).cast<float>());
  }
  return scan;
}

MapScene MadeUpCube() {
  MapScene scene{.name = "made-up cube", .scans = {}, .views = {}, .config = {}};
  scene.config = test::WorkloadBox("cube");
  Rng rng(1);
  for (int i = 0; i < 20; ++i) {
    scene.scans.push_back(LookIntoCube(&rng));
    test::View view{.p_W = scene.scans.back().origin_W, .visual_W = {}, .coverage_W = {}};
    for (int n = 0; n < 200; ++n) {
      const Vector3d d(1, rng.Uniform(-0.6, 0.6), rng.Uniform(-0.45, 0.45));
      view.visual_W.emplace_back(d.normalized().cast<float>());
      view.coverage_W.emplace_back(d.normalized().cast<float>());
    }
    scene.views.push_back(view);
  }
  return scene;
}

}  // namespace

std::vector<MapScene> MapScenes() {
  const std::string folder = test::SharedMapFolder();
  if (folder.empty()) {
    return {MadeUpCube()};
  }
  std::vector<MapScene> scenes;
  for (const std::string name : {"cube", "office"}) {
    scenes.push_back({.name = name,
                      .scans = test::ReadClouds(folder + name + "_clouds.bin"),
                      .views = test::ReadViews(folder + name + "_views.bin"),
                      .config = test::WorkloadBox(name)});
  }
  return scenes;
}

}  // namespace pipewright::bench
