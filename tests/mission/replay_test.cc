// SPDX-License-Identifier: MIT
// A short mission, recorded and replayed: whole, altered, cut, damaged, and on a disk that is full.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "mission.h"
#include "platform/core/rng.h"

namespace pipewright {
namespace {

namespace fs = std::filesystem;
using test::CommandResult;
using test::Json;
using test::ReadFile;
using test::WriteFile;

constexpr const char* kInspect = "--seed 3 --time-limit 10 --record-depth";

struct Replayed {
  int exit_code = -1;
  std::string error;
  Json json;  ///< what --json printed; discarded when it was none
};

Replayed Replay(const fs::path& folder, const std::string& options = "--compare") {
  const CommandResult result =
      test::RunCommand(PIPEWRIGHT_BINARY, "replay '" + folder.string() + "' --json " + options,
                       folder.parent_path());
  return {result.exit_code, result.error,
          Json::parse(result.out, nullptr, /*allow_exceptions=*/false)};
}

/// A line of can.log, taken apart by its description rather than by the reader under test.
struct Line {
  double t_s = 0;
  std::string id;
  std::string payload;
  std::size_t begin = 0;  ///< its first byte
};

std::vector<Line> CanLines(const std::string& log) {
  std::vector<Line> lines;
  for (std::size_t at = 0, feed = 0; (feed = log.find('\n', at)) != std::string::npos;
       at = feed + 1) {
    const std::string text = log.substr(at, feed - at);
    const std::size_t mark = text.find('#');
    lines.push_back(
        {std::stod(text.substr(1)), text.substr(mark - 3, 3), text.substr(mark + 1), at});
  }
  return lines;
}

class ReplayTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    mission_ = new test::MissionRun(
        test::RunMission(fs::path(testing::TempDir()) / "pipewright" / "replay", "recorded",
                         test::ShippedText("pipes1"), kInspect));
  }
  static void TearDownTestSuite() { delete mission_; }

  void SetUp() override { ASSERT_TRUE(mission_->run.is_object()) << mission_->error; }

  static fs::path recorded() { return mission_->folder; }
  static const Json& run() { return mission_->run; }
  static std::string log() { return ReadFile(recorded() / "can.log"); }
  static std::string depth() { return ReadFile(recorded() / "depth.z16.zst"); }

  /// A copy to spoil.
  static fs::path Copy() {
    const fs::path copy = test::TestFolder() / "copy";
    fs::create_directories(copy);
    for (const char* name : {"run.json", "can.log", "depth.z16.zst"}) {
      fs::copy_file(recorded() / name, copy / name);
    }
    return copy;
  }

  static test::MissionRun* mission_;
};

test::MissionRun* ReplayTest::mission_ = nullptr;

TEST_F(ReplayTest, OfARunOfOursIsTheSameByteForByte) {
  const Replayed replay = Replay(recorded());
  EXPECT_EQ(replay.exit_code, 0) << replay.error;
  ASSERT_TRUE(replay.json.is_object());
  const Json& compare = replay.json["compare"];
  EXPECT_TRUE(compare["identical"]) << compare;
  EXPECT_TRUE(compare["first_difference"].is_null());
  EXPECT_EQ(compare["same"], run()["can"]["tx"]);  // all that the robot sent
  EXPECT_EQ(replay.json["log"]["from_devices"], run()["can"]["rx"]);
  EXPECT_NEAR(replay.json["program"]["replayed_s"], run()["sim_time_s"], 0.02);
  EXPECT_EQ(replay.json["program"]["plan_steps"], run()["plan"]["steps"]);
  EXPECT_EQ(replay.json["program"]["voxels"], run()["voxels"]);
  EXPECT_EQ(replay.json["program"]["stop_reason"], "timeout");
  EXPECT_GT(run()["plan"]["steps"], 1);  // it was a mission
}

TEST_F(ReplayTest, WithoutCompareSaysOnlyWhatTheProgramDid) {
  const Replayed replay = Replay(recorded(), "--speed 1000");
  EXPECT_EQ(replay.exit_code, 0) << replay.error;
  EXPECT_TRUE(replay.json["compare"].is_null());
  EXPECT_EQ(replay.json["program"]["plan_steps"], run()["plan"]["steps"]);
}

TEST_F(ReplayTest, NamesTheOneCommandThatWasAltered) {
  const fs::path copy = Copy();
  std::string text = log();
  const std::vector<Line> lines = CanLines(text);
  const auto line = std::find_if(lines.begin() + static_cast<std::ptrdiff_t>(lines.size() / 2),
                                 lines.end(), [](const Line& one) { return one.id == "204"; });
  ASSERT_NE(line, lines.end());
  const std::size_t at = text.find('#', line->begin) + 5;  // the velocity's lowest byte
  text[at] = text[at] == '7' ? '8' : '7';
  WriteFile(copy / "can.log", text);
  const Replayed replay = Replay(copy);
  EXPECT_EQ(replay.exit_code, 1);
  const Json& compare = replay.json["compare"];
  EXPECT_EQ(compare["different"], 1);
  EXPECT_EQ(compare["same"], run()["can"]["tx"].get<int>() - 1);
  EXPECT_EQ(compare["not_recorded"], 0);
  EXPECT_EQ(compare["not_replayed"], 0);
  const Json& first = compare["first_difference"];
  EXPECT_NEAR(first["t_s"], line->t_s, 1e-7);
  EXPECT_EQ(first["id"], "204");
  EXPECT_EQ(first["name"], "rpdo1_joint_command 4");
  EXPECT_EQ(first["replayed"]["payload"], line->payload);
  EXPECT_NE(first["recorded"]["payload"], line->payload);
  EXPECT_NE(first["recorded"]["signals"]["velocity"], first["replayed"]["signals"]["velocity"]);
  const CommandResult told =
      test::RunCommand(PIPEWRIGHT_BINARY, "replay copy --compare", copy.parent_path());
  EXPECT_EQ(told.exit_code, 1);
  EXPECT_NE(told.out.find("204 rpdo1_joint_command 4"), std::string::npos) << told.out;
  EXPECT_NE(told.out.find(line->payload), std::string::npos) << told.out;
}

TEST_F(ReplayTest, OfAProgramThatWasSetUpOtherwiseDiffersAndSaysSo) {
  const struct {
    const char* path;
    Json value;
  } cases[] = {{"/seed", 4},
               {"/planner", "cfnbv_paper"},
               {"/program/start/x_m", 0.36},
               {"/interrupted_s", 3.0}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.path);
    const fs::path copy = Copy();
    Json changed = Json::parse(ReadFile(copy / "run.json"));
    changed[Json::json_pointer(c.path)] = c.value;
    WriteFile(copy / "run.json", changed.dump());
    const Replayed replay = Replay(copy);
    EXPECT_EQ(replay.exit_code, 1);
    const Json& compare = replay.json["compare"];
    EXPECT_FALSE(compare["identical"]);
    EXPECT_GT(compare["different"], 10);
    EXPECT_GT(compare["same"], 100);  // up to there, and what does not hang on it
    EXPECT_TRUE(compare["first_difference"].is_object());
  }
}

TEST_F(ReplayTest, WithoutDepthFeedsWhatThereIsAndSaysSoLoudly) {
  const fs::path copy = Copy();
  fs::remove(copy / "depth.z16.zst");
  const Replayed replay = Replay(copy);
  EXPECT_EQ(replay.exit_code, 1);  // the commands differ
  EXPECT_NE(replay.error.find("WITHOUT DEPTH"), std::string::npos) << replay.error;
  EXPECT_TRUE(replay.json["depth"].is_null());
  EXPECT_EQ(replay.json["program"]["depth_frames"], 0);
  EXPECT_NE(replay.json["program"]["stop_detail"].get<std::string>().find("camera"),
            std::string::npos);
  EXPECT_GT(replay.json["compare"]["same"], 100);
}

/// A log cut at `at`: everything up to its last whole line is the same.
void ExpectSameUpToACut(const fs::path& copy, const std::string& log, std::size_t at) {
  const std::string begin = log.substr(0, at);
  WriteFile(copy / "can.log", begin);
  const std::vector<Line> whole = CanLines(begin);
  const Replayed replay = Replay(copy);
  const bool cut = begin.back() != '\n';
  EXPECT_EQ(replay.exit_code, cut ? 1 : 0);
  EXPECT_EQ(replay.error.find("ends within") != std::string::npos, cut) << replay.error;
  ASSERT_TRUE(replay.json.is_object()) << replay.error;
  EXPECT_TRUE(replay.json["compare"]["identical"]) << replay.json["compare"];
  EXPECT_EQ(replay.json["log"]["frames"], whole.size());
  EXPECT_NEAR(replay.json["program"]["replayed_s"], whole.back().t_s, 0.002);
}

TEST_F(ReplayTest, OfALogThatIsCutGoesToItsLastWholeLine) {
  const fs::path copy = Copy();
  const std::string text = log();
  Rng rng(21);
  for (int k = 0; k < 4; ++k) {
    const auto from = text.size() / 10;
    const std::size_t at =
        from + static_cast<std::size_t>(rng.Index(static_cast<int>(text.size() - from)));
    SCOPED_TRACE(at);
    ExpectSameUpToACut(copy, text, at);
  }
  ExpectSameUpToACut(copy, text, text.find('\n', text.size() / 2) + 1);
}

TEST_F(ReplayTest, OfDepthThatIsCutOrDamagedGoesToItsLastWholeFrame) {
  const fs::path copy = Copy();
  const std::string bytes = depth();
  const std::size_t middle = bytes.size() / 2 + 77;
  std::string damaged = bytes;
  damaged[middle] = static_cast<char>(damaged[middle] ^ 0x10);
  for (const std::string& spoilt : {bytes.substr(0, middle), damaged}) {
    WriteFile(copy / "depth.z16.zst", spoilt);
    const Replayed replay = Replay(copy);
    EXPECT_EQ(replay.exit_code, 1);
    EXPECT_NE(replay.error.find("depth.z16.zst: ends after"), std::string::npos) << replay.error;
    EXPECT_TRUE(replay.json["compare"]["identical"]) << replay.json["compare"];
    const double replayed_s = replay.json["program"]["replayed_s"];
    EXPECT_GT(replayed_s, 0.3 * run()["sim_time_s"].get<double>());
    EXPECT_LT(replayed_s, 0.8 * run()["sim_time_s"].get<double>());
    // A frame each 1/15 s from 0 on, and each had its last cycle.
    const int frames = replay.json["depth"]["frames"];
    EXPECT_NEAR(replayed_s, (frames - 1) / 15.0, 0.003);
  }
}

TEST_F(ReplayTest, OfALogWithAByteFlippedEndsAndSaysWhatIsWrong) {
  const fs::path copy = Copy();
  const std::string text = log();
  Rng rng(22);
  for (int k = 0; k < 4; ++k) {
    const auto at = static_cast<std::size_t>(rng.Index(static_cast<int>(text.size())));
    SCOPED_TRACE(at);
    std::string damaged = text;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << rng.Index(8)));
    WriteFile(copy / "can.log", damaged);
    const Replayed replay = Replay(copy);
    EXPECT_TRUE(replay.exit_code == 0 || replay.exit_code == 1) << replay.error;
    EXPECT_TRUE(replay.json.is_object()) << replay.error;
  }
}

/// The same mission in a shell that lets no file grow beyond `blocks` of 512 bytes.
test::MissionRun OnAFullDisk(const fs::path& place, int blocks) {
  fs::create_directories(place);
  WriteFile(place / "cell.toml", test::ShippedText("pipes1"));
  WriteFile(place / "run.sh",
            "trap '' XFSZ\nulimit -f " + std::to_string(blocks) + "\nexec '" + PIPEWRIGHT_BINARY +
                "' inspect --scenario cell.toml --out evidence --json " + kInspect);
  const CommandResult result = test::RunCommand("/bin/sh", "run.sh", place);
  return {result.exit_code, result.error, Json::parse(result.out, nullptr, false),
          place / "evidence"};
}

TEST_F(ReplayTest, ADiskThatIsFullChangesNothingOfTheRunAndItsLogReplaysToItsLastWholeRecord) {
  const fs::path place = test::TestFolder();
  const std::string whole_log = log();
  const std::string whole_depth = depth();
  const struct {
    const char* name;
    int blocks;
    bool cuts_log;
  } cases[] = {{"depth", static_cast<int>((whole_log.size() + 200'000) / 512), false},
               {"both", static_cast<int>(whole_log.size() * 3 / 4 / 512), true}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    ASSERT_LT(static_cast<std::size_t>(c.blocks) * 512, whole_depth.size());
    const test::MissionRun full = OnAFullDisk(place / c.name, c.blocks);
    EXPECT_EQ(full.exit_code, 1);
    EXPECT_NE(full.error.find("could not be written whole"), std::string::npos) << full.error;
    const std::string its_log = ReadFile(full.folder / "can.log");
    EXPECT_EQ(its_log.size() < whole_log.size(), c.cuts_log);
    EXPECT_TRUE(whole_log.starts_with(its_log));  // the robot did what it did
    const std::string its_depth = ReadFile(full.folder / "depth.z16.zst");
    EXPECT_LT(its_depth.size(), whole_depth.size());
    EXPECT_TRUE(whole_depth.starts_with(its_depth));
    const Json ended = Json::parse(ReadFile(full.folder / "run.json"));
    for (const char* key : {"sim_time_s", "voxels", "path", "can", "stop_reason"}) {
      EXPECT_EQ(ended[key], run()[key]) << key;
    }
    const Replayed replay = Replay(full.folder);
    EXPECT_EQ(replay.exit_code, 1);
    EXPECT_NE(replay.error.find("replayed what is whole, up to"), std::string::npos);
    EXPECT_TRUE(replay.json["compare"]["identical"]) << replay.json["compare"];
    EXPECT_GT(replay.json["compare"]["same"], 500);
  }
}

}  // namespace
}  // namespace pipewright
