// SPDX-License-Identifier: MIT
#include "hil/cli/run_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "hil/plant/robot_description.h"
#include "hil/replay/depth_reader.h"
#include "hil/replay/depth_recording.h"
#include "platform/can/candump.h"
#include "tests/support/command.h"

namespace pipewright::hil {
namespace {

namespace fs = std::filesystem;
using test::ReadFile;
using test::TestFolder;
using test::WriteFile;
using Json = nlohmann::ordered_json;

const Json kHead = {{"scenario", "cell"}, {"stop_reason", "running"}};

std::vector<std::string> Fields(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ',');) {
    fields.push_back(field);
  }
  return fields;
}

std::vector<std::string> Lines(const fs::path& path) {
  std::vector<std::string> lines;
  std::istringstream in(ReadFile(path));
  for (std::string line; std::getline(in, line);) {
    lines.push_back(line);
  }
  return lines;
}

/// A bit of a run: one line of each kind.
void Live(RunFolder& folder) {
  const Plant plant(TracerUf7Description(), {0.5, -0.25, 0.125}, Vec<kPlantJoints>::Zero());
  ControlReport report;
  report.now = Time{std::chrono::milliseconds(1230)};
  report.progress.id = 7;
  report.state.q(9) = 0.75;
  report.sent(0) = -0.3;
  Clearance clearance;
  clearance.contacts = 2;
  folder.Trace(report, &plant, &clearance, {.free = 5, .covered = 3});
  folder.Can({.id = 0x111, .dlc = 2, .data = {0xAB, 0xCD}, .stamp = report.now}, "can0");
  folder.Plan({{"t_s", 1.25}, {"step", 1}});
}

TEST(RunFolder, MakesAFolderWithItsParentsAndSaysThatTheRunIsOn) {
  const fs::path path = TestFolder() / "a" / "b";
  RunFolder folder;
  ASSERT_EQ(folder.Open(path, kHead), "");
  EXPECT_EQ(folder.path(), path);
  EXPECT_EQ(Json::parse(ReadFile(path / "run.json")), kHead);
  for (const char* name : {"trace.csv", "can.log", "plan.jsonl"}) {
    EXPECT_TRUE(fs::exists(path / name)) << name;
  }
}

TEST(RunFolder, LeavesAFolderAloneThatHoldsSomethingElse) {
  const fs::path path = TestFolder();
  WriteFile(path / "thesis.txt", "years of work");
  WriteFile(path / "can.log", "mine");
  RunFolder folder;
  const std::string error = folder.Open(path, kHead);
  EXPECT_NE(error.find(path.string()), std::string::npos) << error;
  EXPECT_EQ(ReadFile(path / "thesis.txt"), "years of work");
  EXPECT_EQ(ReadFile(path / "can.log"), "mine");
  EXPECT_FALSE(fs::exists(path / "run.json"));
}

TEST(RunFolder, SaysWhatIsWrongWithAPlaceThatCannotBeAFolder) {
  const fs::path path = TestFolder() / "file";
  WriteFile(path, "");
  RunFolder folder;
  EXPECT_NE(folder.Open(path, kHead).find("is not a folder"), std::string::npos);
  EXPECT_NE(folder.Open(path / "below", kHead), "");
}

TEST(RunFolder, OverwritesAnEarlierRunAndLeavesNothingOfIt) {
  const fs::path path = TestFolder() / "run";
  {
    RunFolder earlier;
    ASSERT_EQ(earlier.Open(path, kHead), "");
    for (int i = 0; i < 10; ++i) {
      Live(earlier);
    }
    earlier.Text("report.html", "old");
    earlier.Map(VoxelGrid(MapConfig{}));
    ASSERT_EQ(earlier.Close(), "");
    ASSERT_TRUE(fs::exists(path / "map.bt") && fs::exists(path / "map.ot"));
  }
  RunFolder folder;
  ASSERT_EQ(folder.Open(path, kHead), "");
  EXPECT_EQ(folder.Close(), "");
  for (const char* old : {"map.bt", "map.ot", "report.html"}) {
    EXPECT_FALSE(fs::exists(path / old)) << old;
  }
  EXPECT_EQ(Lines(path / "trace.csv").size(), 1U);  // the head
  EXPECT_EQ(ReadFile(path / "can.log"), "");
  EXPECT_EQ(ReadFile(path / "plan.jsonl"), "");
}

TEST(RunFolder, LeavesWhatItSawWhenTheRunBreaksOff) {
  const fs::path path = TestFolder() / "run";
  {
    RunFolder folder;
    ASSERT_EQ(folder.Open(path, kHead), "");
    Live(folder);
  }  // an exception, say: nobody called Close()
  EXPECT_EQ(Json::parse(ReadFile(path / "run.json"))["stop_reason"], "running");
  EXPECT_EQ(Lines(path / "trace.csv").size(), 2U);
  EXPECT_EQ(Lines(path / "can.log").size(), 1U);
  EXPECT_EQ(Json::parse(ReadFile(path / "plan.jsonl"))["step"], 1);
}

TEST(RunFolder, WritesALineOfTraceWithAFieldForEachColumn) {
  const fs::path path = TestFolder() / "run";
  RunFolder folder;
  ASSERT_EQ(folder.Open(path, kHead), "");
  Live(folder);
  ASSERT_EQ(folder.Close(), "");
  const std::vector<std::string> lines = Lines(path / "trace.csv");
  ASSERT_EQ(lines.size(), 2U);
  const std::vector<std::string> names = Fields(lines[0]);
  const std::vector<std::string> values = Fields(lines[1]);
  ASSERT_EQ(names.size(), values.size());
  const auto value = [&](const char* name) {
    const auto at = std::find(names.begin(), names.end(), name) - names.begin();
    return std::stod(values.at(static_cast<std::size_t>(at)));
  };
  EXPECT_EQ(value("t_s"), 1.23);
  EXPECT_EQ(value("goal"), 7);
  EXPECT_EQ(value("q7_rad"), 0.75);
  EXPECT_EQ(value("v_mps"), -0.3);
  EXPECT_EQ(value("true_x_m"), 0.5);
  EXPECT_EQ(value("true_y_m"), -0.25);
  EXPECT_EQ(value("true_phi_rad"), 0.125);
  EXPECT_EQ(value("contacts"), 2);
  EXPECT_EQ(value("free"), 5);
  EXPECT_EQ(value("covered"), 3);
}

TEST(RunFolder, WritesNanForATruthThatIsNotKnown) {
  const fs::path path = TestFolder() / "run";
  RunFolder folder;
  ASSERT_EQ(folder.Open(path, kHead), "");
  folder.Trace({}, nullptr, nullptr, {});
  ASSERT_EQ(folder.Close(), "");
  const std::vector<std::string> lines = Lines(path / "trace.csv");
  ASSERT_EQ(lines.size(), 2U);
  const std::vector<std::string> names = Fields(lines[0]);
  const std::vector<std::string> values = Fields(lines[1]);
  ASSERT_EQ(names.size(), values.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& name = names[i];
    const bool of_truth =
        name.starts_with("true_") || name.starts_with("clear_") || name == "contacts";
    EXPECT_EQ(values[i] == "nan", of_truth) << name << " is " << values[i];
  }
}

TEST(RunFolder, WritesFramesAsCandumpDoes) {
  const fs::path path = TestFolder() / "run";
  RunFolder folder;
  ASSERT_EQ(folder.Open(path, kHead), "");
  Live(folder);
  ASSERT_EQ(folder.Close(), "");
  EXPECT_EQ(ReadFile(path / "can.log"), "(0000000001.230000) can0 111#ABCD\n");
}

TEST(RunFolder, RecordsDepthOnlyWhenAsked) {
  const fs::path path = TestFolder() / "run";
  const auto frame = std::make_unique<DepthFrame>();
  frame->camera = {2, 1, 1, 1, 0.5, 0, 0.1, 5};
  frame->depth_mm[1] = 1234;
  const auto record = [&](bool asked) {
    RunFolder folder;
    ASSERT_EQ(folder.Open(path, kHead, asked), "");
    folder.Depth(*frame, Time{std::chrono::milliseconds(70)});
    EXPECT_EQ(folder.Close(), "");
  };
  record(true);
  DepthReader reader;
  ASSERT_EQ(reader.Open(path / kDepthFileName), "");
  const auto read = std::make_unique<DepthFrame>();
  Time given{};
  ASSERT_TRUE(reader.Next(*read, given));
  EXPECT_EQ(given, Time{std::chrono::milliseconds(70)});
  EXPECT_EQ(read->depth_mm, frame->depth_mm);
  EXPECT_FALSE(reader.Next(*read, given));
  EXPECT_EQ(reader.end(), "");
  record(false);  // and nothing is left of the earlier run's
  EXPECT_FALSE(fs::exists(path / kDepthFileName));
}

TEST(RunFolder, PutsATextInPlaceWholeAndSaysWhenItCannot) {
  const fs::path path = TestFolder() / "run";
  RunFolder folder;
  ASSERT_EQ(folder.Open(path, kHead), "");
  folder.Text("run.json", "{}\n");
  EXPECT_EQ(ReadFile(path / "run.json"), "{}\n");
  EXPECT_FALSE(fs::exists(path / "run.json.part"));
  folder.Text("no/such/place.html", "x");
  EXPECT_NE(folder.Close().find("place.html"), std::string::npos);
}

}  // namespace
}  // namespace pipewright::hil
