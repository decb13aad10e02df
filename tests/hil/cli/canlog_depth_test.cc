// SPDX-License-Identifier: MIT
// `pipewright canlog export --depth` as a person types it. What is in the file is tested by
// mcap_points_by_spec.py.
#include <gtest/gtest.h>

#include <memory>

#include "hil/replay/depth_writer.h"
#include "tests/support/command_json.h"

namespace pipewright::hil {
namespace {

using nlohmann::json;
using namespace test;

namespace fs = std::filesystem;

CommandResult Canlog(const std::string& arguments, const fs::path& folder) {
  return RunCommand(PIPEWRIGHT_BINARY, "canlog " + arguments, folder);
}

/// Depth frames of 4 x 4 pixels at 1, 2, 3 s. @returns the file's bytes
std::string RecordDepth(const fs::path& path) {
  DepthWriter writer;
  EXPECT_TRUE(writer.Open(path));
  const auto frame = std::make_unique<DepthFrame>();
  frame->camera = {4, 4, 5, 5, 2, 2, 0.1, 6};
  for (const int second : {1, 2, 3}) {
    frame->stamp = Time(std::chrono::seconds(second));
    writer.Add(*frame, frame->stamp);
  }
  EXPECT_TRUE(writer.Close());
  return ReadFile(path);
}

const std::string kOfThreeSeconds = "(0.500000) can0 421#01\n(3.500000) can0 421#01\n";

TEST(CanlogExportDepth, WritesDepthFramesAsPointsAndSaysWhatIsMissing) {
  const fs::path folder = TestFolder();
  RecordDepth(folder / "depth.zst");
  WriteFile(folder / "a.log", kOfThreeSeconds);
  const json run = Parsed(Canlog("a.log export --mcap a.mcap --depth depth.zst --json", folder));
  EXPECT_EQ(run["topics"], json::parse(R"([{"topic": "/camera/points",
      "type": "sensor_msgs/msg/PointCloud2", "messages": 3}])"));
  EXPECT_EQ(run["depth"], json::parse(R"({"path": "depth.zst", "frames": 3, "outside_log": 0,
      "without_joints": 3, "ends_early": null})"));
  WriteFile(folder / "a.log", "(1.500000) can0 421#01\n" + kOfThreeSeconds);
  const CommandResult text =
      Canlog("a.log export --mcap a.mcap --depth depth.zst --from @0.5 --to @2.5", folder);
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_EQ(text.error, "");
  EXPECT_NE(text.out.find("depth.zst: 3 depth frames; 2 are outside the log's time and left out, "
                          "of 1 the joints are not known\n"),
            std::string::npos)
      << text.out;
}

TEST(CanlogExportDepth, WritesTheDepthFramesThatAreWhole) {
  const fs::path folder = TestFolder();
  const std::string whole = RecordDepth(folder / "depth.zst");
  WriteFile(folder / "a.log", kOfThreeSeconds);
  std::string damaged = whole;
  damaged[whole.size() - 40] = static_cast<char>(~damaged[whole.size() - 40]);
  for (const std::string& bytes : {whole.substr(0, whole.size() - 30), damaged}) {
    WriteFile(folder / "depth.zst", bytes);
    const CommandResult result =
        Canlog("a.log export --mcap a.mcap --depth depth.zst --json", folder);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_NE(result.error.find("pipewright: depth.zst: ends after 2 frames: "), std::string::npos)
        << result.error;
    const json run = json::parse(result.out);
    EXPECT_EQ(run["topics"][0]["messages"], 2);
    EXPECT_EQ(run["depth"]["frames"], 2);
    EXPECT_TRUE(run["depth"]["ends_early"].is_string());
  }
}

TEST(CanlogExportDepth, RefusesDepthFramesThatAreNotOfTheLogsTime) {
  const fs::path folder = TestFolder();
  RecordDepth(folder / "depth.zst");
  const struct {
    const char* log;
    const char* expected;
  } cases[] = {
      {"(1700000000.000000) can0 421#01\n(1700000009.500000) can0 421#01\n",
       "pipewright: depth.zst: its depth frames are of 1.000000 to 3.000000 s, the frames of a.log "
       "of 1700000000.000000 to 1700000009.500000 s"},
      {"(0.100000) can0 421#01\n(0.900000) can0 421#01\n", "a.log of 0.100000 to 0.900000 s"},
      {"  can0  421   [1]  01\n", "no frame of a.log has a time"},
      {"", "no frame of a.log has a time"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.log);
    WriteFile(folder / "a.log", c.log);
    const CommandResult result = Canlog("a.log export --mcap a.mcap --depth depth.zst", folder);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.error.find(c.expected), std::string::npos) << result.error;
    EXPECT_FALSE(fs::exists(folder / "a.mcap"));
  }
}

TEST(CanlogExportDepth, RefusesDepthThatItCannotReadOrWasNotAskedFor) {
  const fs::path folder = TestFolder();
  RecordDepth(folder / "depth.zst");
  WriteFile(folder / "a.log", kOfThreeSeconds);
  const struct {
    const char* arguments;
    const char* expected;
  } cases[] = {
      {"--depth depth.zst", "--depth requires --mcap"},
      {"--mcap a.mcap --points-every 2", "--points-every requires --depth"},
      {"--mcap a.mcap --depth depth.zst --points-every 0", "--points-every"},
      {"--mcap a.mcap --depth none.zst", "none.zst: no such file"},
      {"--mcap a.mcap --depth a.log", "a.log: is no depth recording"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.arguments);
    const CommandResult result = Canlog(std::string("a.log export ") + c.arguments, folder);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.error.find(c.expected), std::string::npos) << result.error;
    EXPECT_FALSE(fs::exists(folder / "a.mcap"));
  }
}

}  // namespace
}  // namespace pipewright::hil
