// SPDX-License-Identifier: MIT
// The map beside liboctomap, on the same scans and rays, in one run. With PIPEWRIGHT_SHARED set the
// scans are those of its data/map (cube and office), else twenty made-up looks into a cube with
// three pipes. Compare only figures of one run on one machine.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>

#include "perception/map/distance_field.h"
#include "perception/map/ray_walk.h"
#include "platform/core/rng.h"
#include "tests/perception/map/map_data.h"

namespace pipewright {
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

struct Scene {
  std::vector<Scan> scans;
  std::vector<test::View> views;
  MapConfig config;
};

const Scene& TheScene(const std::string& name) {
  static std::map<std::string, Scene> scenes;
  Scene& scene = scenes[name];
  if (scene.scans.empty()) {
    const std::string folder = test::SharedMapFolder();
    scene.config = test::WorkloadBox(name);
    if (!folder.empty()) {
      scene.scans = test::ReadClouds(folder + name + "_clouds.bin");
      scene.views = test::ReadViews(folder + name + "_views.bin");
      return scene;
    }
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
  }
  return scene;
}

VoxelGrid Ours(const Scene& scene) {
  VoxelGrid grid(scene.config);
  for (const Scan& scan : scene.scans) {
    test::InsertOurs(&grid, scan);
  }
  return grid;
}

octomap::OcTree Theirs(const Scene& scene) {
  octomap::OcTree tree(0.05);
  for (const Scan& scan : scene.scans) {
    test::InsertOctomap(&tree, scan);
  }
  return tree;
}

void InsertOurs(benchmark::State& state, const char* name, bool discretize) {
  const Scene& scene = TheScene(name);
  VoxelGrid grid(scene.config);
  std::size_t i = 0;
  for (auto _ : state) {
    test::InsertOurs(&grid, scene.scans[i++ % scene.scans.size()], discretize);
  }
  state.counters["MB"] = static_cast<double>(grid.MemoryBytes()) / 1e6;
}

void InsertOctomap(benchmark::State& state, const char* name, bool discretize) {
  const Scene& scene = TheScene(name);
  octomap::OcTree tree(0.05);
  std::size_t i = 0;
  for (auto _ : state) {
    test::InsertOctomap(&tree, scene.scans[i++ % scene.scans.size()], discretize);
  }
  state.counters["MB"] = static_cast<double>(tree.memoryUsage()) / 1e6;
}

// Every iteration: the visual rays of one view. Divide by 200 for one ray.
void CastOurs(benchmark::State& state, const char* name, bool batch) {
  const Scene& scene = TheScene(name);
  const VoxelGrid grid = Ours(scene);
  std::vector<RayHit> hits(scene.views[0].visual_W.size());
  std::size_t i = 0;
  for (auto _ : state) {
    const test::View& view = scene.views[i++ % scene.views.size()];
    const auto n = static_cast<int>(hits.size());
    if (batch) {
      grid.CastRays(view.p_W, view.visual_W.data(), n, 5.0, true, hits.data());
    } else {
      for (int k = 0; k < n; ++k) {
        hits[k] = grid.CastRay(view.p_W.cast<double>(), view.visual_W[k].cast<double>(), 5.0, true);
      }
    }
    benchmark::DoNotOptimize(hits.data());
  }
}

void CastOctomap(benchmark::State& state, const char* name) {
  const Scene& scene = TheScene(name);
  const octomap::OcTree tree = Theirs(scene);
  std::size_t i = 0;
  for (auto _ : state) {
    const test::View& view = scene.views[i++ % scene.views.size()];
    for (const Vector3f& d : view.visual_W) {
      octomap::point3d end;
      benchmark::DoNotOptimize(
          tree.castRay(test::ToOctomap(view.p_W), test::ToOctomap(d), end, true, 5.0));
    }
  }
}

// Every iteration: unknown voxels along one view's visual rays, as the planner's gain counts them.
void GainOurs(benchmark::State& state, const char* name) {
  const Scene& scene = TheScene(name);
  const VoxelGrid grid = Ours(scene);
  std::size_t i = 0;
  for (auto _ : state) {
    const test::View& view = scene.views[i++ % scene.views.size()];
    int unknown = 0;
    for (const Vector3f& d : view.visual_W) {
      RayWalk ray(grid, view.p_W, view.p_W + d * 3.0F);
      while (ray.Next() && ray.inside() && !grid.OccupiedAt(ray.index())) {
        unknown += grid.KnownAt(ray.index()) ? 0 : 1;
      }
    }
    benchmark::DoNotOptimize(unknown);
  }
}

void GainOctomap(benchmark::State& state, const char* name) {
  const Scene& scene = TheScene(name);
  const octomap::OcTree tree = Theirs(scene);
  std::size_t i = 0;
  octomap::KeyRay keys;
  const octomap::OcTreeKey lo = test::KeyOf(scene.config.lo);
  const octomap::OcTreeKey hi = test::KeyOf(scene.config.hi);
  for (auto _ : state) {
    const test::View& view = scene.views[i++ % scene.views.size()];
    int unknown = 0;
    for (const Vector3f& d : view.visual_W) {
      tree.computeRayKeys(test::ToOctomap(view.p_W), test::ToOctomap(view.p_W + d * 3.0F), keys);
      for (const octomap::OcTreeKey& key : keys) {
        if (key[0] < lo[0] || key[1] < lo[1] || key[2] < lo[2] || key[0] > hi[0] ||
            key[1] > hi[1] || key[2] > hi[2]) {
          break;
        }
        const octomap::OcTreeNode* node = tree.search(key);
        if (node != nullptr && tree.isNodeOccupied(node)) {
          break;
        }
        unknown += node == nullptr ? 1 : 0;
      }
    }
    benchmark::DoNotOptimize(unknown);
  }
}

void RebuildField(benchmark::State& state) {
  Scene scene = TheScene("cube");
  scene.config.lo = {-5, -5, -5};
  scene.config.hi = {34, 34, 34};  // 40 x 40 x 40
  scene.config.brick_capacity = BricksOfBox(scene.config);
  VoxelGrid grid = Ours(scene);
  DistanceField field(grid.config());
  bool residue = false;
  for (auto _ : state) {
    grid.Restore({34, 34, 34}, residue ? 1.0F : -1.0F);  // something changed
    residue = !residue;
    field.Update(grid);
  }
}

void QueryField(benchmark::State& state) {
  const VoxelGrid grid = Ours(TheScene("cube"));
  DistanceField field(grid.config());
  field.Update(grid);
  Rng rng(1);
  Vector3d points[256];
  for (Vector3d& p : points) {
    p = {rng.Uniform(0, 1.5), rng.Uniform(0, 1.5), rng.Uniform(0, 1.5)};
  }
  unsigned i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(state.range(0) == 0 ? field.Distance(points[i++ % 256])
                                                 : field.DistanceAtLeast(points[i++ % 256]));
  }
}

BENCHMARK_CAPTURE(InsertOurs, cube, "cube", false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(InsertOctomap, cube, "cube", false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(InsertOurs, cube_discretised, "cube", true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(InsertOctomap, cube_discretised, "cube", true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(CastOurs, cube_one_by_one, "cube", false);
BENCHMARK_CAPTURE(CastOurs, cube_batch, "cube", true);
BENCHMARK_CAPTURE(CastOctomap, cube, "cube");
BENCHMARK_CAPTURE(GainOurs, cube, "cube");
BENCHMARK_CAPTURE(GainOctomap, cube, "cube");
BENCHMARK(RebuildField)->Unit(benchmark::kMillisecond);
BENCHMARK(QueryField)->Arg(0)->Arg(1);

void AddOffice() {
  using benchmark::RegisterBenchmark;
  for (const bool d : {false, true}) {
    const std::string mode = d ? "/office_discretised" : "/office";
    RegisterBenchmark(("InsertOurs" + mode).c_str(), InsertOurs, "office", d)
        ->Unit(benchmark::kMillisecond);
    RegisterBenchmark(("InsertOctomap" + mode).c_str(), InsertOctomap, "office", d)
        ->Unit(benchmark::kMillisecond);
  }
  RegisterBenchmark("CastOurs/office_batch", CastOurs, "office", true);
  RegisterBenchmark("CastOctomap/office", CastOctomap, "office");
  RegisterBenchmark("GainOurs/office", GainOurs, "office");
  RegisterBenchmark("GainOctomap/office", GainOctomap, "office");
}

}  // namespace
}  // namespace pipewright

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (!pipewright::test::SharedMapFolder().empty()) {
    pipewright::AddOffice();
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
