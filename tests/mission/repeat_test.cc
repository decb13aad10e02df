// SPDX-License-Identifier: MIT
// One short mission on a shipped scenario, twice: a run is a function of its inputs.
#include "mission.h"

namespace pipewright {
namespace {

namespace fs = std::filesystem;
using test::Json;
using test::MissionRun;

/// run.json without what the wall clock says.
Json WithoutWallClock(const Json& json) {
  if (!json.is_object()) {
    return json;
  }
  Json rest = Json::object();
  for (const auto& [key, value] : json.items()) {
    if (key != "wall_time_s" && !key.ends_with("_us") && !key.ends_with("_ms")) {
      rest[key] = WithoutWallClock(value);
    }
  }
  return rest;
}

TEST(ShortMission, IsTheSameTwiceAndTouchesNothing) {
  const fs::path folder = test::TestFolder();
  const std::string pipes1 = test::ShippedText("pipes1");
  const MissionRun first = test::RunMission(folder, "first", pipes1, "--seed 3 --time-limit 40");
  const MissionRun second = test::RunMission(folder, "second", pipes1, "--seed 3 --time-limit 40");
  for (const MissionRun* mission : {&first, &second}) {
    test::ExpectWholeFolder(*mission);
    ASSERT_TRUE(mission->run.is_object()) << mission->error;
    EXPECT_EQ(mission->run["stop_reason"], "timeout");
    EXPECT_EQ(mission->exit_code, 1);
    EXPECT_EQ(mission->run["contacts"], 0) << mission->run["touched"];
    EXPECT_EQ(mission->run["control"]["heap_allocations"], 0);
    EXPECT_LT(mission->run["control"]["lateral_speed_max_mps"], 1e-9);
    EXPECT_LE(mission->run["control"]["joint_limit_excess_rad"], 0);
    EXPECT_EQ(mission->run["can"]["dropped"], 0);
    // It went to work: it looked, planned and moved.
    EXPECT_GT(mission->run["voxels"]["free"], 1000);
    EXPECT_GT(mission->run["plan"]["steps"], 0);
    EXPECT_GT(mission->run["path"]["joint_rad"], 0.5);
    EXPECT_GT(mission->run["coverage"]["truth_covered"], 0);
  }
  EXPECT_EQ(WithoutWallClock(first.run), WithoutWallClock(second.run));

  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(first.folder)) {
    names.push_back(entry.path().filename());
  }
  EXPECT_GE(names.size(), 7U);
  for (const std::string& name : names) {
    if (name != "run.json" && name != "report.html") {
      EXPECT_TRUE(test::ReadFile(first.folder / name) == test::ReadFile(second.folder / name))
          << name << " differs";
    }
  }
  EXPECT_TRUE(fs::exists(second.folder / "report.html"));
}

}  // namespace
}  // namespace pipewright
