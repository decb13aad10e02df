// SPDX-License-Identifier: MIT
#include "hil/world/coverage.h"

#include <gtest/gtest.h>

#include <set>

#include "platform/core/rng.h"

namespace pipewright::hil {
namespace {

Scenario Cell(const std::string& solids) {
  const ScenarioResult result = ParseScenario(
      "name='t'\n[workspace]\nmin_m=[0,0,0]\nmax_m=[1,1,1]\n[start]\nx_m=0\ny_m=0\nyaw_rad=0\n" +
          solids,
      "t", "");
  EXPECT_TRUE(result.scenario) << result.errors[0];
  return *result.scenario;
}

const char* const kShelf = "[[box]]\nname='b'\ncenter_m=[0.5,0.5,0.525]\nsize_m=[3,3,0.01]\n";

TEST(SampleSurface, OfAPlaneIsOneLayerOfVoxels) {
  const SurfaceVoxels s =
      SampleSurface(Cell("[[plane]]\nname='p'\nnormal=[0,0,1]\noffset_m=0.52\n"));
  EXPECT_EQ(s.voxels.size(), 400U);
  for (const SurfaceVoxels::Voxel& v : s.voxels) {
    EXPECT_EQ(v.index[2], 10);
    EXPECT_GE(v.count, 16);  // at most 12.5 mm apart
  }
}

// Oracle: points drawn on the cylinder's surface at random.
TEST(SampleSurface, OfAPipeIsEveryVoxelItsSurfaceReallyPasses) {
  const Scenario scenario =
      Cell("[[cylinder]]\nname='c'\nfrom_m=[0.2,0.3,0.1]\nto_m=[0.8,0.6,1.2]\nradius_m=0.07\n");
  const SurfaceVoxels s = SampleSurface(scenario);
  std::set<std::array<int, 3>> sampled;
  for (const SurfaceVoxels::Voxel& v : s.voxels) {
    sampled.insert(v.index);
  }
  const Solid& pipe = scenario.solids[0];
  std::map<std::array<int, 3>, int> drawn;
  Rng rng(41);
  const int points = 400000;
  for (int i = 0; i < points; ++i) {
    const double angle = rng.Uniform(0, 6.283185307179586);
    const Vector3d p = pipe.X_WG * Vector3d(0.07 * std::cos(angle), 0.07 * std::sin(angle),
                                            pipe.shape.size_m.y() * rng.Uniform(-0.5, 0.5));
    const Eigen::Array3d cell = (p.array() / 0.05).floor();
    if ((cell >= 0).all() && (cell < 20).all()) {
      ++drawn[{static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())}];
    }
  }
  // A voxel with a patch of more than a few sample areas cannot be missed.
  const double area = 6.283185307179586 * 0.07 * pipe.shape.size_m.y();
  for (const auto& [index, count] : drawn) {
    if (count * area / points > 4 * 0.0125 * 0.0125) {
      EXPECT_TRUE(sampled.contains(index));
    }
  }
  for (const SurfaceVoxels::Sample& sample : s.samples) {
    ASSERT_NEAR(Distance(pipe, Vector3d(sample.p_W.cast<double>())), 0, 1e-6);
    const Vector3d out = (sample.p_W + 0.01F * sample.n_W).cast<double>();
    ASSERT_NEAR(Distance(pipe, out), 0.01, 1e-6);
  }
}

TEST(SampleSurface, LeavesOutWhatIsInsideAnotherSolid) {
  const SurfaceVoxels s = SampleSurface(Cell(
      "[[box]]\nname='outer'\ncenter_m=[0.52,0.52,0.52]\nsize_m=[0.6,0.6,0.6]\n"
      "[[cylinder]]\nname='inner'\nfrom_m=[0.5,0.5,0.4]\nto_m=[0.5,0.5,0.6]\nradius_m=0.05\n"));
  for (const SurfaceVoxels::Sample& sample : s.samples) {
    EXPECT_NEAR((sample.p_W.array() - 0.52F).abs().maxCoeff(), 0.3F, 1e-5F);
  }
}

TEST(SampleSurface, OfAHugeSolidIsAsLargeAsTheWorkspace) {
  const SurfaceVoxels s =
      SampleSurface(Cell("[[box]]\nname='b'\ncenter_m=[0.5,0.5,-99.475]\nsize_m=[200,200,200]\n"
                         "[[cylinder]]\nname='c'\nfrom_m=[0.5,0.5,-90]\nto_m=[0.5,0.5,90]\n"
                         "radius_m=0.1\n"));
  EXPECT_LT(s.samples.size(), 30000U);
  EXPECT_GT(s.voxels.size(), 400U);
}

// Above a plane at height h the sphere of radius r covers a disc of radius sqrt(r^2 - h^2).
TEST(CoverageProbe, CoversTheDiscBelowItOnAPlane) {
  const Scenario scenario = Cell("[[plane]]\nname='p'\nnormal=[0,0,1]\noffset_m=0.52\n");
  const SurfaceVoxels s = SampleSurface(scenario);
  const RayScene rays(scenario.solids);
  const CoverageProbe probe(s, rays, 0.4);
  const Vector3d p_WP(0.47, 0.53, 0.52 + 0.24);
  for (int i = 0; i < static_cast<int>(s.voxels.size()); ++i) {
    const Eigen::Vector2d lo(s.voxels[i].index[0] * 0.05, s.voxels[i].index[1] * 0.05);
    const Eigen::Vector2d near =
        p_WP.head<2>().cwiseMax(lo).cwiseMin(lo + Eigen::Vector2d(.05, .05));
    const double nearest = (near - p_WP.head<2>()).norm();
    if (nearest < 0.32 - 0.018) {  // samples are up to 17.7 mm from the voxel's nearest corner
      EXPECT_TRUE(probe.Covers(p_WP, i));
    } else if (nearest > 0.32) {
      EXPECT_FALSE(probe.Covers(p_WP, i));
    }
  }
  const Vector3d below(0.47, 0.53, 0.5);
  std::vector<std::uint8_t> covered(s.voxels.size(), 0);
  EXPECT_EQ(probe.Add(below, covered), 0) << "a plane has one side";
}

TEST(CoverageProbe, DoesNotCoverBehindAShelf) {
  const Scenario scenario =
      Cell(std::string("[[plane]]\nname='p'\nnormal=[0,0,1]\noffset_m=0.42\n") + kShelf);
  const SurfaceVoxels s = SampleSurface(scenario);
  const RayScene rays(scenario.solids);
  const CoverageProbe probe(s, rays, 0.4);
  std::vector<std::uint8_t> covered(s.voxels.size(), 0);
  const int added = probe.Add({0.5, 0.5, 0.6}, covered);
  EXPECT_GT(added, 100);
  for (std::size_t i = 0; i < covered.size(); ++i) {
    if (covered[i] != 0) {
      EXPECT_EQ(s.voxels[i].index[2], 10);  // the shelf's top, and nothing below
    }
  }
  EXPECT_EQ(probe.Add({0.5, 0.5, 0.6}, covered), 0) << "nothing is new the second time";
}

// Oracle: visibility on a lone convex pipe needs no rays: the probe is in front of the tangent
// plane.
TEST(CoverageProbe, CoversOfAPipeTheSideThatFacesIt) {
  const Scenario scenario =
      Cell("[[cylinder]]\nname='c'\nfrom_m=[0.52,0.51,-1]\nto_m=[0.52,0.51,2]\nradius_m=0.13\n");
  const SurfaceVoxels s = SampleSurface(scenario);
  const RayScene rays(scenario.solids);
  const CoverageProbe probe(s, rays, 0.4);
  Rng rng(42);
  for (int k = 0; k < 50; ++k) {
    const Vector3d p_WP(rng.Uniform(0.1, 0.9), rng.Uniform(0.1, 0.9), rng.Uniform(0.3, 0.7));
    if (Distance(scenario.solids[0], p_WP) < 0.02) {
      continue;
    }
    for (int i = 0; i < static_cast<int>(s.voxels.size()); ++i) {
      double best = -1;  // of the tangent planes; those within 0.5 mm are too close to call
      for (int j = s.voxels[i].first; j < s.voxels[i].first + s.voxels[i].count; ++j) {
        const Vector3d to_P = p_WP - s.samples[j].p_W.cast<double>();
        if (to_P.norm() < 0.4) {
          best = std::max(best, s.samples[j].n_W.cast<double>().dot(to_P));
        }
      }
      if (std::abs(best) > 5e-4) {
        ASSERT_EQ(probe.Covers(p_WP, i), best > 0);
      }
    }
  }
}

}  // namespace
}  // namespace pipewright::hil
