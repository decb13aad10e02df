// SPDX-License-Identifier: MIT
// `pipewright map` as a person types it: figures, files of results, and words for what is wrong.
// That the map is OctoMap's is tested in tests/perception/map; here, that it comes out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "hil/cli/heap_watch.h"
#include "platform/core/frames.h"
#include "platform/core/rng.h"
#include "tests/support/command_json.h"
#include "tests/support/scan_bytes.h"

namespace pipewright::hil {
namespace {

using nlohmann::json;
using test::CommandResult;
using test::Parsed;
using test::RaysFile;
using test::ReadFile;
using test::ScanBytes;
using test::ScansFile;
using test::TestFolder;
using test::ViewsFile;
using test::WriteFile;

namespace fs = std::filesystem;

// One ray along x through the voxels 0, 1, 2 into 3.
std::string OneRay() { return ScansFile({0.025F, 0.025F, 0.025F}, {{0.175F, 0.025F, 0.025F}}); }

CommandResult Map(const std::string& arguments, const fs::path& folder) {
  return test::RunCommand(PIPEWRIGHT_BINARY, "map " + arguments, folder);
}

TEST(MapCommand, TeachesByHelp) {
  const CommandResult help = Map("--help", TestFolder());
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_EQ(help.error, "");
  for (const char* expected :
       {"FILE", "--rays", "--views", "--box", "--window", "--discretise", "--repeat", "--dump",
        "--hits", "--gains", "--json", "Exit code", "Example"}) {
    EXPECT_NE(help.out.find(expected), std::string::npos) << expected;
  }
}

TEST(MapCommand, SaysOfOneRayWhatItDidToTheMap) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "one.bin", OneRay());
  for (const char* options : {"", " --discretise"}) {
    const json run = Parsed(Map(std::string("one.bin --json") + options, folder));
    EXPECT_EQ(run["scans"], 1);
    EXPECT_EQ(run["width_m"], 0.05);
    EXPECT_EQ(run["insertion"]["points"], 1);
    EXPECT_EQ(run["insertion"]["hits"], 1);
    EXPECT_EQ(run["insertion"]["misses"], 3);
    EXPECT_EQ(run["map"]["lo"], json({-2, -2, -2}));
    EXPECT_EQ(run["map"]["hi"], json({5, 2, 2}));
    EXPECT_EQ(run["map"]["free"], 3);
    EXPECT_EQ(run["map"]["occupied"], 1);
    EXPECT_EQ(run["map"]["unknown"], 8 * 5 * 5 - 4);
    EXPECT_GT(run["memory"]["bytes"], 0);
    EXPECT_EQ(run["memory"]["bricks_used"], 1);
    EXPECT_EQ(run["heap_allocations"], HeapWatch::Counting() ? json(0) : json(nullptr));
    EXPECT_FALSE(run.contains("rays") || run.contains("views"));
  }
}

TEST(MapCommand, DumpsEveryKnownVoxelAndItsLogOdds) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "one.bin", OneRay());
  EXPECT_EQ(Map("one.bin --dump map.bin", folder).exit_code, 0);
  ScanBytes expected("MPM1");
  expected.Count(4);
  std::string bytes = expected.str();
  for (int x = 0; x < 4; ++x) {
    const std::uint16_t key[3] = {static_cast<std::uint16_t>(32768 + x), 32768, 32768};
    const auto log_odds = static_cast<float>(std::log(x == 3 ? 0.7 / 0.3 : 0.4 / 0.6));
    bytes.append(reinterpret_cast<const char*>(key), 6);
    bytes.append(reinterpret_cast<const char*>(&log_odds), 4);
  }
  EXPECT_EQ(ReadFile(folder / "map.bin"), bytes);
}

/// Each known voxel's ten bytes of a dump, in order of their keys.
std::vector<std::string> VoxelsOf(const fs::path& dump) {
  const std::string bytes = ReadFile(dump);
  std::vector<std::string> voxels;
  for (std::size_t at = 8; at + 10 <= bytes.size(); at += 10) {
    voxels.push_back(bytes.substr(at, 10));
  }
  std::sort(voxels.begin(), voxels.end());
  return voxels;
}

/// Away by 4 m and back again, with a range that a window of 2.4 m holds wherever it is.
TEST(MapCommand, AWindowLosesNothingOnTheWay) {
  const fs::path folder = TestFolder();
  Rng rng(1);
  std::vector<test::ScanFrom> scans;
  for (const double x : {0.0, 0.9, 2.0, 4.0, 3.1, 1.3, 0.1}) {
    const Vector3d origin(x, 0.3 * x, -0.1 * x);
    test::ScanFrom scan{{static_cast<float>(origin.x()), static_cast<float>(origin.y()),
                         static_cast<float>(origin.z())},
                        {}};
    for (int i = 0; i < 300; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        scan.points.push_back(static_cast<float>(origin(axis) + rng.Uniform(-1.5, 1.5)));
      }
    }
    scans.push_back(scan);
  }
  WriteFile(folder / "way.bin", ScansFile(scans, 0.9F));
  const json all = Parsed(Map("way.bin --dump all.bin --json", folder));
  const json window = Parsed(Map("way.bin --window 2.4 --dump window.bin --json", folder));
  EXPECT_FALSE(all.contains("window"));
  EXPECT_GE(window["window"]["moves"], 6);
  EXPECT_GT(window["window"]["bricks_left"], 0);
  EXPECT_LT(window["memory"]["bytes"], all["memory"]["bytes"]);
  EXPECT_EQ(window["heap_allocations"], HeapWatch::Counting() ? json(0) : json(nullptr));
  const std::vector<std::string> expected = VoxelsOf(folder / "all.bin");
  EXPECT_GT(expected.size(), 1000U);
  EXPECT_EQ(VoxelsOf(folder / "window.bin"), expected);

  const CommandResult table = Map("way.bin --window 2.4", folder);
  EXPECT_NE(table.out.find("bricks left it"), std::string::npos) << table.out;
  for (const char* wrong : {"--window 0", "--window -1", "--window x", "--window 2000",
                            "--window 2 --box 0 0 0 7 7 7"}) {
    const CommandResult result = Map(std::string("way.bin ") + wrong, folder);
    EXPECT_EQ(result.exit_code, 2) << wrong;
    EXPECT_NE(result.error.find("--window"), std::string::npos) << result.error;
  }
}

TEST(MapCommand, WritesWhereRaysEnd) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "one.bin", OneRay());
  WriteFile(folder / "rays.bin", RaysFile(1, {{0.025F, 0.025F, 0.025F, 1, 0, 0},
                                              {0.025F, 0.025F, 0.025F, -1, 0, 0},
                                              {0.075F, 0.025F, 0.025F, 2, 0, 0}}));
  const json run = Parsed(Map("one.bin --rays rays.bin --hits hits.bin --json", folder));
  EXPECT_EQ(run["rays"]["count"], 3);
  EXPECT_EQ(run["rays"]["unknown_ends"]["hits"], 2);
  EXPECT_EQ(run["rays"]["unknown_ignored"]["hits"], 2);
  const std::string hits = ReadFile(folder / "hits.bin");
  ASSERT_EQ(hits.size(), 2 * (8 + 3 * 8U));
  for (const std::size_t at : {0U, 32U}) {
    EXPECT_EQ(hits.substr(at, 4), "MPH1");
    const auto word = [&](std::size_t i) {
      std::uint16_t value = 0;
      std::memcpy(&value, &hits[at + 8 + 2 * i], 2);
      return value;
    };
    EXPECT_EQ(word(0), 1);
    EXPECT_EQ(word(1), 32768 + 3);
    EXPECT_EQ(word(4), 0);
    EXPECT_EQ(word(5), at == 0 ? 32767 : 32768 - 21);  // the first unknown, or beyond the range
    EXPECT_EQ(word(8), 1);
    EXPECT_EQ(word(9), 32768 + 3);
  }
}

TEST(MapCommand, EvaluatesViews) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "one.bin", OneRay());
  WriteFile(folder / "views.bin",
            ViewsFile({0.025F, 0.025F, 0.025F}, {1, 0, 0, -1, 0, 0}, {1, 0, 0, 0, 1, 0}));
  const json run = Parsed(
      Map("one.bin --views views.bin --gains gains.bin --box -5 -5 -5 5 5 5 --json", folder));
  EXPECT_EQ(run["map"]["lo"], json({-5, -5, -5}));
  EXPECT_EQ(run["views"]["count"], 1);
  EXPECT_EQ(run["views"]["unknown"], 5);  // -1 to -5
  EXPECT_EQ(run["views"]["visual_hits"], 1);
  EXPECT_EQ(run["views"]["coverage_hits"], 1);
  EXPECT_EQ(ReadFile(folder / "gains.bin").size(), 8 + 16U);
}

TEST(MapCommand, PrintsATableForPeople) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "one.bin", OneRay());
  WriteFile(folder / "rays.bin", RaysFile(1, {{0.025F, 0.025F, 0.025F, 1, 0, 0}}));
  WriteFile(folder / "views.bin", ViewsFile({0, 0, 0}, {1, 0, 0}, {}));
  const CommandResult result = Map("one.bin --rays rays.bin --views views.bin", folder);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  for (const char* expected : {"insertion", "3 free, 1 occupied", "bytes a voxel", "1 hits of 1",
                               "ended by unknown voxels", "views", "allocations"}) {
    EXPECT_NE(result.out.find(expected), std::string::npos) << expected << " in\n" << result.out;
  }
}

TEST(MapCommand, SaysWhatIsWrongAndPrintsNoResult) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "one.bin", OneRay());
  WriteFile(folder / "cut.bin", OneRay().substr(0, 90));
  WriteFile(folder / "far.bin", ScansFile({0, 0, 0}, {{900, 900, 900}}));
  const struct {
    const char* arguments;
    const char* expected;
  } cases[] = {
      {"none.bin", "none.bin: no such file"},
      {"cut.bin --json", "cut.bin: is cut short at byte 90: scan 0: its points"},
      {"far.bin", "far.bin: cannot store voxels -2 -2 -2 to 18001 18001 18001: at most 2^27"},
      {"one.bin --rays one.bin", "one.bin: is not MPR1"},
      {"one.bin --views one.bin", "one.bin: is not MPV1"},
      {"one.bin --box 5 5 5 0 0 0", "lo first"},
      {"one.bin --box 5 5 5", "--box"},
      {"one.bin --hits out", "--rays"},
      {"one.bin --gains out", "--views"},
      {"one.bin --repeat 0", "--repeat"},
      {"", "FILE"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.arguments);
    const CommandResult result = Map(c.arguments, folder);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.error.find(c.expected), std::string::npos) << result.error;
  }
  const CommandResult nowhere = Map("one.bin --dump none/map.bin", folder);
  EXPECT_EQ(nowhere.exit_code, 1);
  EXPECT_NE(nowhere.error.find("none/map.bin: cannot be written"), std::string::npos);
}

TEST(MapCommand, GivesTheSharedSetsTheirReferences) {
  const char* const shared = std::getenv("PIPEWRIGHT_SHARED");
  if (shared == nullptr) {
    GTEST_SKIP() << "SKIPPED: set PIPEWRIGHT_SHARED to the folder that holds data/map to check its "
                    "references";
  }
  const fs::path folder = TestFolder();
  const std::string data = std::string(shared) + "/data/map/";
  for (const auto& [scene, box] :
       {std::pair{"cube", "-2 -2 -2 32 32 32"}, std::pair{"office", "-8 -8 -8 608 408 68"}}) {
    SCOPED_TRACE(scene);
    const std::string set = data + scene;
    EXPECT_EQ(Map(set + "_clouds.bin --repeat 1 --gains gains.bin --views " + set +
                      "_views.bin --box " + box,
                  folder)
                  .exit_code,
              0);
    EXPECT_TRUE(ReadFile(folder / "gains.bin") == ReadFile(set + "_views_ref.bin"));
  }
  // In any order, so by the size and by the sum of all words.
  EXPECT_EQ(Map(data + "cube_clouds.bin --repeat 1 --dump map.bin", folder).exit_code, 0);
  const auto sum = [](const std::string& bytes) {
    std::uint64_t all = 0;
    for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
      std::uint16_t word = 0;
      std::memcpy(&word, &bytes[i], 2);
      all += word;
    }
    return std::pair{bytes.size(), all};
  };
  EXPECT_EQ(sum(ReadFile(folder / "map.bin")), sum(ReadFile(data + "cube_map20_ref.bin")));
}

}  // namespace
}  // namespace pipewright::hil
