// SPDX-License-Identifier: MIT
#include "tests/bench/map_gain.h"

#include <vector>

#include "plan/gain/gain.h"
#include "platform/core/rng.h"
#include "tests/bench/stopwatch.h"

namespace pipewright::bench {

double TimeGain(const MapScene& scene, int passes) {
  VoxelGrid grid(scene.config);
  for (const test::Scan& scan : scene.scans) {
    test::InsertOurs(&grid, scan);
  }
  const GainConfig config;
  GainEvaluator gains(config, scene.config);
  gains.Update(grid);
  Rng rng(1);
  const RaySet camera = LatticeCameraRays(config);
  const RaySet probe = RandomSphereRays(config, rng);
  std::vector<Viewpoint> views;
  for (const test::View& view : scene.views) {
    const double x = rng.Normal();
    const double y = rng.Normal();
    const Vector3d z_WS = Vector3d(x, y, rng.Normal()).normalized();
    views.push_back(UprightViewpoint(view.p_W.cast<double>(), z_WS));
  }
  std::vector<ViewGain> found(views.size());
  Stopwatch watch;
  for (int pass = 0; pass < passes; ++pass) {
    for (std::size_t view = 0; view < views.size(); ++view) {
      watch.Time(view, [&] {
        found[view] = gains.Evaluate(views[view], camera, probe, GainCount::kDistinct);
      });
    }
  }
  return 1e6 * watch.least_s() / static_cast<double>(views.size());
}

}  // namespace pipewright::bench
