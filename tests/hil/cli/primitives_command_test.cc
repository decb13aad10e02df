// SPDX-License-Identifier: MIT
// `pipewright primitives` as a person types it: what is found in clouds that are known, exit codes,
// and words for files that are no clouds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "platform/core/frames.h"
#include "platform/core/rng.h"
#include "tests/support/command_json.h"
#include "tests/support/pcd_file.h"

namespace pipewright::hil {
namespace {

using nlohmann::json;
using test::CommandResult;
using test::Parsed;

namespace fs = std::filesystem;

CommandResult Primitives(const std::string& arguments, const fs::path& folder) {
  return test::RunCommand(PIPEWRIGHT_BINARY, "primitives " + arguments, folder);
}

/// A wall z = 1.5 as a camera at the origin sees it, its noise 0.002 z^2.
std::vector<Eigen::Vector3f> WallImage(int width, int height) {
  Rng rng(3);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < width * height; ++i) {
    const double z = 1.5 + 0.002 * 1.5 * 1.5 * rng.Normal();
    const double x = (i % width - (width - 1) / 2.0) / width;
    const double y = (i / width - (height - 1) / 2.0) / width;
    points.push_back(Eigen::Vector3d(x * z, y * z, z).cast<float>());
  }
  return points;
}

double Dot(const json& a, const json& b) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    sum += a[k].get<double>() * b[k].get<double>();
  }
  return sum;
}

TEST(PrimitivesCommand, TeachesByHelp) {
  const CommandResult help = Primitives("--help", test::TestFolder());
  EXPECT_EQ(help.exit_code, 0);
  for (const char* expected :
       {"FILE", "--sigma", "--reach", "--json", "chi2", "clusters", "Exit code", "Example: "}) {
    EXPECT_NE(help.out.find(expected), std::string::npos) << expected;
  }
}

TEST(PrimitivesCommand, FindsTheWallOfAnImageAndOfTheSamePointsInNoOrder) {
  const fs::path folder = test::TestFolder();
  const auto points = WallImage(160, 120);
  test::WriteFile(folder / "image.pcd", test::BinaryPcd(points, 120));
  test::WriteFile(folder / "points.pcd", test::CompressedPcd(points));
  for (const char* arguments :
       {"image.pcd --sigma 0.002 --json", "points.pcd --sigma 0.005 --json"}) {
    SCOPED_TRACE(arguments);
    const json run = Parsed(Primitives(arguments, folder));
    EXPECT_EQ(run["organised"], arguments[0] == 'i');
    EXPECT_EQ(run["points"], 160 * 120);
    EXPECT_EQ(run["pipes"], json::array());
    ASSERT_EQ(run["planes"].size(), 1u);
    const json& plane = run["planes"][0];
    EXPECT_NEAR(plane["n"][2], -1, 1e-4);
    EXPECT_NEAR(plane["d_m"], -1.5, 0.001);
    EXPECT_LT(plane["offset_sigma_m"], 0.001);
    EXPECT_EQ(plane["covariance"].size(), 4u);
    EXPECT_NEAR(plane["extent_m"][0], 1.5, 0.1);
  }
  const CommandResult table = Primitives("image.pcd --sigma 0.002", folder);
  for (const char* expected : {"as a depth image", "plane  n", "chi2", "1 planes, 0 pipes"}) {
    EXPECT_NE(table.out.find(expected), std::string::npos) << table.out;
  }
}

/// Before the wall of WallImage, balls of noisy points that float in the air.
std::vector<Eigen::Vector3f> Balls(const std::vector<Vector3d>& centers_S, int points_each) {
  constexpr double kRadius_m = 0.04;
  Rng rng(5);
  std::vector<Eigen::Vector3f> points;
  for (const Vector3d& center_S : centers_S) {
    for (int i = 0; i < points_each; ++i) {
      const Vector3d out = Vector3d(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
      points.emplace_back((center_S + kRadius_m * out).cast<float>());
    }
  }
  return points;
}

TEST(PrimitivesCommand, ClustersWhatNeitherAPlaneNorAPipeExplains) {
  const fs::path folder = test::TestFolder();
  auto points = WallImage(160, 120);
  // The second two are 6 cm apart, between their surfaces.
  const auto balls = Balls({{-0.4, 0, 1}, {0.2, 0.1, 1}, {0.34, 0.1, 1}}, 200);
  points.insert(points.end(), balls.begin(), balls.end());
  points.emplace_back(0, 0, 0.5F);  // noise
  test::WriteFile(folder / "points.pcd", test::BinaryPcd(points));
  const json run = Parsed(Primitives("points.pcd --sigma 0.005 --json", folder));
  EXPECT_EQ(run["planes"].size(), 1u);
  EXPECT_GE(run["unexplained"], 601);
  EXPECT_LE(run["unexplained"], 640) << "the wall's own outliers";
  EXPECT_EQ(run["clusters_left_out"], 0);
  EXPECT_EQ(run["spacing_rad"], 0);
  ASSERT_EQ(run["clusters"].size(), 3u);
  for (const json& ball : run["clusters"]) {
    EXPECT_EQ(ball["points"], 200);
    EXPECT_NEAR(ball["centroid_m"][2], 1, 0.01);
    for (const std::size_t axis : {0, 1, 2}) {
      const double lo = ball["min_m"][axis];
      const double hi = ball["max_m"][axis];
      EXPECT_NEAR(hi - lo, 0.08, 0.005);
      EXPECT_NEAR(ball["spread_m"][axis], 0.04 / std::sqrt(3), 0.004);
    }
  }
  EXPECT_NEAR(run["clusters"][0]["centroid_m"][0], -0.4, 0.01) << "of one size, the first first";
  for (const char* wider : {"--reach 0.07", "--reach 0.01 --spacing 0.07"}) {
    const json wide =
        Parsed(Primitives(std::string("points.pcd --json --sigma 0.005 ") + wider, folder));
    ASSERT_EQ(wide["clusters"].size(), 2u) << wider;
    EXPECT_EQ(wide["clusters"][0]["points"], 400);
  }
  const CommandResult table = Primitives("points.pcd --sigma 0.005", folder);
  for (const char* expected : {"cluster  p (", "box 0.08 x 0.08 x 0.08 m  200 points",
                               "1 planes, 0 pipes, 3 clusters of 6"}) {
    EXPECT_NE(table.out.find(expected), std::string::npos) << table.out;
  }
}

TEST(PrimitivesCommand, ClustersAnImagesReadingsByItsPixels) {
  const fs::path folder = test::TestFolder();
  auto points = WallImage(160, 120);
  for (const int row : {50, 51, 52, 53, 54, 55, 56, 57}) {
    for (const int column : {20, 21, 22, 23, 24, 25, 26, 27}) {
      points[row * 160 + column] *= 0.6F;  // a lone patch before the wall, too small for a plane
    }
  }
  test::WriteFile(folder / "image.pcd", test::BinaryPcd(points, 120));
  const json run = Parsed(Primitives("image.pcd --sigma 0.002 --reach 0.001 --json", folder));
  EXPECT_EQ(run["organised"], true);
  EXPECT_NEAR(run["spacing_rad"], 3.0 / 160, 0.001);
  ASSERT_EQ(run["clusters"].size(), 1u);
  EXPECT_EQ(run["clusters"][0]["points"], 64);
  EXPECT_NEAR(run["clusters"][0]["centroid_m"][2], 0.9, 0.01);
  const json apart =
      Parsed(Primitives("image.pcd --sigma 0.002 --reach 0.001 --spacing 0 --json", folder));
  EXPECT_EQ(apart["clusters"], json::array());
}

TEST(PrimitivesCommand, SaysWhatIsWrongAndPrintsNoResult) {
  const fs::path folder = test::TestFolder();
  test::WriteFile(folder / "cut.pcd", test::BinaryPcd(WallImage(8, 8)).substr(0, 300));
  test::WriteFile(folder / "good.pcd", test::BinaryPcd(WallImage(8, 8)));
  const struct {
    const char* arguments;
    const char* expected;
  } cases[] = {{"cut.pcd", "cut.pcd: is cut short at byte 300"},
               {"none.pcd", "none.pcd: no such file"},
               {"good.pcd --radius-min 0.5", "--radius-min is not below --radius-max"},
               {"good.pcd --sigma 0", "--sigma"},
               {"good.pcd --sigma nan", "--sigma"},
               {"good.pcd --reach 0", "--reach"},
               {"good.pcd --spacing nan", "--spacing"},
               {"", "FILE"}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.arguments);
    const CommandResult result = Primitives(c.arguments, folder);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.error.find(c.expected), std::string::npos) << result.error;
  }
  EXPECT_EQ(Parsed(Primitives("good.pcd --json", folder))["planes"], json::array());
}

class RealClouds : public testing::Test {
 protected:
  void SetUp() override {
    const char* const shared = std::getenv("PIPEWRIGHT_SHARED");
    if (shared == nullptr) {
      GTEST_SKIP() << "SKIPPED: set PIPEWRIGHT_SHARED to the folder that holds data/clouds to look "
                      "at real scans";
    }
    clouds_ = fs::path(shared) / "data/clouds";
  }
  json Run(const std::string& file, const std::string& options = "") const {
    std::string arguments = (clouds_ / file).string();
    arguments += " --json ";
    arguments += options;
    return Parsed(Primitives(arguments, test::TestFolder()));
  }

 private:
  fs::path clouds_;
};

TEST_F(RealClouds, TheTableAndTheMugThatStandsOnIt) {
  const json run = Run("table_scene_mug_stereo_textured.pcd");
  EXPECT_EQ(run["organised"], true);
  EXPECT_EQ(run["points"], 209280);
  ASSERT_GE(run["planes"].size(), 1u);
  ASSERT_EQ(run["pipes"].size(), 1u);
  const json& mug = run["pipes"][0];
  EXPECT_NEAR(mug["radius_m"], 0.039, 0.003);
  const double upright = std::abs(Dot(run["planes"][0]["n"], mug["l"]));
  EXPECT_GT(upright, std::cos(0.07)) << "the mug leans by " << std::acos(upright) << " rad";
  // Its handle, beside it, is of no primitive.
  const auto handle =
      std::count_if(run["clusters"].begin(), run["clusters"].end(), [&](const json& cluster) {
        const double off = std::hypot(cluster["centroid_m"][0].get<double>() - 0.115,
                                      cluster["centroid_m"][1].get<double>() - 0.07,
                                      cluster["centroid_m"][2].get<double>() - 0.76);
        return off < 0.02 && cluster["points"] > 100;
      });
  EXPECT_EQ(handle, 1);
}

TEST_F(RealClouds, AMugThatMayBeNoPipeIsOneCluster) {
  const json run = Run("table_scene_mug_stereo_textured.pcd", "--radius-min 0.1");
  EXPECT_EQ(run["pipes"], json::array());
  int on_the_table = 0;
  for (const json& cluster : run["clusters"]) {
    if (cluster["centroid_m"][2] > 1.2) {
      continue;  // what stands behind
    }
    ++on_the_table;
    EXPECT_GT(cluster["points"], 800);
    for (const auto& [axis, extent_m] : {std::pair<std::size_t, double>{0, 0.15}, {1, 0.13}}) {
      EXPECT_NEAR(cluster["max_m"][axis].get<double>() - cluster["min_m"][axis].get<double>(),
                  extent_m, 0.03);
    }
  }
  EXPECT_EQ(on_the_table, 1);
}

TEST_F(RealClouds, ThePoleOfALamppost) {
  const json run = Run("lamppost.pcd");
  EXPECT_EQ(run["points"], 1771);
  ASSERT_GE(run["pipes"].size(), 1u);
  const json& pole = run["pipes"][0];
  EXPECT_GT(std::abs(pole["l"][2].get<double>()), 0.99);
  EXPECT_GT(pole["hi_m"].get<double>() - pole["lo_m"].get<double>(), 4);
  EXPECT_NEAR(pole["radius_m"], 0.05, 0.03);
}

TEST_F(RealClouds, FloorCeilingAndWallsOfARoom) {
  for (const auto& [file, points] :
       {std::pair{"room_scan1.pcd", 112586}, {"room_scan2.pcd", 112624}}) {
    SCOPED_TRACE(file);
    const json run = Run(file, "--sigma 0.015");
    EXPECT_EQ(run["points"], points);
    int level = 0;
    int upright = 0;
    for (const json& plane : run["planes"]) {
      const double up = std::abs(plane["n"][2].get<double>());
      level += up > 0.99;
      upright += up < 0.1;
    }
    EXPECT_GE(level, 2);
    EXPECT_GE(upright, 3);
  }
}

}  // namespace
}  // namespace pipewright::hil
