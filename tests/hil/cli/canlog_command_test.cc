// SPDX-License-Identifier: MIT
// `pipewright canlog` as a person types it. That logs are read right is tested in tests/hil/canlog.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "tests/support/can_logs.h"
#include "tests/support/command_json.h"

namespace pipewright::hil {
namespace {

using nlohmann::json;
using namespace test;

namespace fs = std::filesystem;

const std::string kStartup = std::string(PIPEWRIGHT_TEST_DATA) + "/can/canopen_csv_startup.log";

CommandResult Canlog(const std::string& arguments, const fs::path& folder) {
  return RunCommand(PIPEWRIGHT_BINARY, "canlog " + arguments, folder);
}

TEST(CanlogCommand, TeachesByHelp) {
  const CommandResult help = Canlog("--help", TestFolder());
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_EQ(help.error, "");
  for (const char* expected : {"FILE", "--id", "--from", "--to", "--deltas", "--bitrate", "--json",
                               "stats", "Exit code", "Example"}) {
    EXPECT_NE(help.out.find(expected), std::string::npos) << expected;
  }
}

TEST(CanlogCommand, GivesTheStatisticsOfALogThatAnotherLibraryMade) {
  // Counted by hand with grep and awk.
  const json run = Parsed(Canlog("'" + kStartup + "' --bitrate 1000000 --json", TestFolder()));
  EXPECT_EQ(run["files"][0]["format"], "candump -L");
  EXPECT_EQ(run["files"][0]["frames"], 147);
  EXPECT_EQ(run["files"][0]["bytes"], 5899);
  EXPECT_EQ(run["all"]["frames"], 147);
  EXPECT_EQ(run["channels"][0]["channel"], "vcan1");
  ASSERT_EQ(run["ids"].size(), 7U);
  const json& sync = run["ids"][1];
  EXPECT_EQ(sync["id"], "080");
  EXPECT_EQ(sync["name"], "sync");
  EXPECT_EQ(sync["frames"], 34);
  EXPECT_EQ(run["ids"][6]["name"], "heartbeat 1");
  EXPECT_NEAR(run["ids"][6]["rate_hz"].get<double>(), 24 / 2.351604, 1e-6);
  EXPECT_GT(run["all"]["bits"], 147 * 47);
  EXPECT_EQ(run["frames_beyond_ids"], 0);
}

TEST(CanlogCommand, TakesTheWordBeforeOrBehindTheFileAndReadsStandardInput) {
  const fs::path folder = TestFolder();
  const std::string file = "'" + kStartup + "'";
  const CommandResult plain = Canlog(file, folder);
  EXPECT_EQ(plain.exit_code, 0);
  EXPECT_NE(plain.out.find("rpdo1_joint_command 1"), std::string::npos);
  EXPECT_EQ(Canlog(file + " stats", folder).out, plain.out);
  EXPECT_EQ(Canlog("stats " + file, folder).out, plain.out);
  const json run = Parsed(Canlog("- --json <" + file, folder));
  EXPECT_EQ(run["all"]["frames"], 147);
  EXPECT_EQ(run["files"][0]["path"], "-");
}

TEST(CanlogCommand, TellsWhatCameWhenAPersonEndsTheSender) {
  const fs::path folder = TestFolder();
  // sleep: should the signal come too early, the shell has it ignored, and the test passes as well
  WriteFile(folder / "run.sh", "mkfifo pipe\n" PIPEWRIGHT_BINARY
                               " canlog - --json <pipe &\nreader=$!\nexec 3>pipe\ncat '" +
                                   kStartup +
                                   "' >&3\nsleep 0.2\nkill -INT $reader\nsleep 0.1\nexec 3>&-\n"
                                   "wait $reader\n");
  EXPECT_EQ(Parsed(RunCommand("/bin/sh", "run.sh", folder))["all"]["frames"], 147);
}

TEST(CanlogCommand, ChoosesFramesByIdAndTime) {
  const fs::path folder = TestFolder();
  const std::string file = "'" + kStartup + "' --json ";
  EXPECT_EQ(Parsed(Canlog(file + "--id 580/780,601", folder))["all"]["frames"], 64);
  EXPECT_EQ(Parsed(Canlog(file + "--id 701 --to 0.1", folder))["all"]["frames"], 2);
  EXPECT_EQ(Parsed(Canlog(file + "--id 701 --from @1795305883.5", folder))["all"]["frames"], 4);
}

TEST(CanlogCommand, TellsOfWhatItCouldNotReadAndExitsWithOne) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "bad.log", "(1.0) can0 123#11\n(2.0) can0 123#1\n(3.0) can0 1");
  const CommandResult result = Canlog("bad.log --json", folder);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.error.find("bad.log: line 2: expected at most 8 bytes in pairs of hex digits"),
            std::string::npos);
  EXPECT_NE(result.error.find("bad.log: ends within line 3"), std::string::npos);
  const json run = json::parse(result.out);
  EXPECT_EQ(run["files"][0]["malformed"], 1);
  EXPECT_EQ(run["files"][0]["ends_early"], "ends within line 3");
  EXPECT_EQ(run["all"]["frames"], 1);
}

TEST(CanlogCommand, RefusesBadInputWithTwo) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "list.txt", "milk\nbread\n");
  const struct {
    const char* arguments;
    const char* expected;
  } cases[] = {
      {"", "FILE"},
      {"none.log", "none.log: no such file"},
      {"list.txt", "list.txt: is no log that is known here"},
      {"list.txt --id 9999999999", "--id 9999999999: is neither"},
      {"list.txt --from soon", "--from soon: is neither"},
      {"list.txt --bitrate 7", "--bitrate"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.arguments);
    const CommandResult result = Canlog(c.arguments, folder);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.error.find(c.expected), std::string::npos) << result.error;
  }
}

const std::string kSdkClient = std::string(PIPEWRIGHT_TEST_DATA) + "/can/tracer_sdk_client.log";

TEST(CanlogDecode, PrintsFramesInWordsAsCsvAndAsJson) {
  const fs::path folder = TestFolder();
  const std::string file = "'" + kSdkClient + "' decode ";
  EXPECT_EQ(Canlog(file + "--id 111", folder).out,
            "1795305000.020000  vcan0   111  base_twist_command       v=0.5 m/s; omega=0 rad/s\n"
            "1795305000.040000  vcan0   111  base_twist_command       v=0.5 m/s; omega=-0.3 "
            "rad/s\n");
  EXPECT_EQ(Canlog(file + "--csv --signal omega,mode", folder).out,
            "t_s,channel,id,frame,node,signal,value,unit,name\n"
            "1795305000.000000,vcan0,421,base_mode_request,0,mode,1,,\"CAN\"\n"
            "1795305000.020000,vcan0,111,base_twist_command,0,omega,0,rad/s,\n"
            "1795305000.040000,vcan0,111,base_twist_command,0,omega,-0.3,rad/s,\n");
  const json run = Parsed(Canlog(file + "--json", folder));
  ASSERT_EQ(run["frames"].size(), 4U);
  EXPECT_EQ(run["frames"][0], json({{"t_s", 1795305000.0},
                                    {"channel", "vcan0"},
                                    {"id", "421"},
                                    {"frame", "base_mode_request"},
                                    {"signals", {{"mode", "CAN"}}}}));
  EXPECT_EQ(run["frames"][3]["signals"]["front_percent"], 40);
  EXPECT_EQ(run["counts"]["decoded"], 4);
  EXPECT_EQ(run["files"][0]["frames"], 4);
}

TEST(CanlogDecode, SaysWhatItCouldNotDecode) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "a.log",
            "(1.000000) can0 211#00\n(2.000000) can0 123#\n(3.000000) can0 421#09\n"
            "(4.000000) can0 20000040#0000000000000000\n");
  const CommandResult text = Canlog("a.log decode", folder);
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_EQ(text.out,
            "1.000000  can0    211  base_state              ? 1 bytes: wrong length\n"
            "3.000000  can0    421  base_mode_request       ? 1 bytes: a signal is outside its "
            "limits\n"
            "4.000000  can0    error 40  bus off\n");
  EXPECT_NE(text.error.find("frames decoded: 0; with an id"), std::string::npos) << text.error;
  const json run = Parsed(Canlog("a.log decode --json", folder));
  EXPECT_EQ(run["frames"][0]["wrong"], "wrong length");
  EXPECT_EQ(run["frames"][2]["error"], "bus off");
  EXPECT_EQ(run["counts"]["wrong_length"], 1);
  EXPECT_EQ(run["counts"]["out_of_range"], 1);
}

TEST(CanlogDecode, RefusesASignalThatThereIsNot) {
  const CommandResult result = Canlog("'" + kSdkClient + "' decode --signal speeed", TestFolder());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.error.find("--signal speeed: means no signal"), std::string::npos);
}

TEST(CanlogGaps, TellsWhatShouldNotBeAndExitsWithOne) {
  const fs::path folder = TestFolder();
  const CommandResult text = Canlog("'" + kStartup + "' gaps", folder);
  EXPECT_EQ(text.exit_code, 1);
  EXPECT_EQ(text.out,
            "1795305883.549384  vcan1   081       emergency 1              emergency        EMCY: "
            "heartbeat lost (0x8130)\n"
            "1795305883.812333  vcan1   080       sync                     gap              silent "
            "for 0.485277 s, expected every 0.010000 s\n"
            "1795305883.812333  vcan1   201       rpdo1_joint_command 1    gap              silent "
            "for 0.493988 s, expected every 0.010000 s\n"
            "\n"
            "gap                      2\n"
            "emergency                1\n");
  const json run = Parsed(Canlog("'" + kStartup + "' gaps --json --most 1", folder), 1);
  EXPECT_EQ(run["findings"].size(), 2U);  // of two kinds
  EXPECT_EQ(run["findings"][1]["kind"], "gap");
  EXPECT_EQ(run["findings"][1]["seconds"], 0.485277);
  EXPECT_EQ(run["counts"]["gap"], 2);
  EXPECT_EQ(run["counts"]["command_expired"], 0);
  const CommandResult none = Canlog("'" + kSdkClient + "' gaps", folder);
  EXPECT_EQ(none.exit_code, 0);
  EXPECT_EQ(none.out, "nothing found\n");
}

TEST(CanlogGaps, NotesAnSdoBeforeANodeIsHeardOfAndExitsWithNone) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "a.log",
            "(1.000000) can0 601#4000100000000000\n(1.100000) can0 601#4000100000000000\n"
            "(1.100500) can0 581#4300100092010200");
  const CommandResult text = Canlog("a.log gaps", folder);
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_EQ(
      text.out,
      "1.100000  can0    601       sdo_request 1            sdo_before_boot  note: SDO 1000h:0 "
      "asked again after 0.100000 s, the node was not heard of yet\n"
      "\n"
      "sdo_before_boot          1, a note and no fault\n"
      "no fault found\n");
  const json run = Parsed(Canlog("a.log gaps --json", folder));
  EXPECT_EQ(run["counts"]["sdo_before_boot"], 1);
  EXPECT_EQ(run["counts"]["sdo_unanswered"], 0);
}

TEST(CanlogDbc, PrintsTheFramesOfOneDeviceOrOfBothAndTakesNoLog) {
  const fs::path folder = TestFolder();
  const CommandResult both = Canlog("dbc", folder);
  EXPECT_EQ(both.exit_code, 0);
  // TRACER user manual v1.2, table 3.4: bytes 0 and 1, the high one first, mm/s.
  EXPECT_NE(both.out.find("BO_ 273 base_twist_command: 8 Host\n"
                          " SG_ v : 7|16@0- (0.001,0) [-1.8|1.8] \"m/s\" Tracer\n"),
            std::string::npos);
  EXPECT_NE(both.out.find("BO_ 391 tpdo1_joint_feedback_7: 8 UF7_7\n"
                          " SG_ position : 0|32@1- (1e-06,0)"),
            std::string::npos);
  const CommandResult base = Canlog("dbc --device tracer --modes tracer1", folder);
  EXPECT_EQ(base.out.find("tpdo1"), std::string::npos);
  EXPECT_NE(base.out.find("VAL_ 529 control_mode 0 \"remote control\" 1 \"CAN\" 2 \"serial\" ;"),
            std::string::npos);
  const CommandResult with_log = Canlog("dbc a.log", folder);
  EXPECT_EQ(with_log.exit_code, 2);
  EXPECT_NE(with_log.error.find("takes no log"), std::string::npos);
  EXPECT_EQ(Canlog("dbc --device ur5e", folder).exit_code, 2);
}

TEST(CanlogLoad, PrintsTheLoadOfEachWindow) {
  const fs::path folder = TestFolder();
  const std::string file = "'" + kStartup + "' load --bitrate 1000000 --window 1 ";
  const CommandResult csv = Canlog(file + "--csv", folder);
  EXPECT_EQ(csv.exit_code, 0);
  EXPECT_TRUE(csv.out.starts_with("t_s,channel,frames,load_percent\n1795305881.460729,vcan1,"))
      << csv.out;
  EXPECT_EQ(std::count(csv.out.begin(), csv.out.end(), '\n'), 4);
  const json run = Parsed(Canlog(file + "--json", folder));
  ASSERT_EQ(run["windows"].size(), 3U);
  int frames = 0;
  double most = 0;
  for (const json& window : run["windows"]) {
    frames += window["frames"].get<int>();
    most = std::max(most, window["load"].get<double>());
  }
  EXPECT_EQ(frames, 147);
  EXPECT_EQ(run["peaks"][0]["load"], most);
  EXPECT_NE(Canlog(file, folder).out.find("vcan1    peak"), std::string::npos);
}

TEST(CanlogDiff, SaysWhereTwoLogsPart) {
  const fs::path folder = TestFolder();
  const std::vector<LogFrame> frames = RandomFrames(500, 9);
  std::vector<LogFrame> others = frames;
  others[300].data[0] = static_cast<std::uint8_t>(others[300].data[0] ^ 1);
  others[300].length = frames[300].length == 0 ? 1 : frames[300].length;
  WriteFile(folder / "a.log", CandumpLog(frames));
  WriteFile(folder / "a.pcap.gz", Gz(Pcap(frames, true, false)));
  WriteFile(folder / "b.asc", AscText(others));
  const CommandResult same = Canlog("diff a.log a.pcap.gz", folder);
  EXPECT_EQ(same.exit_code, 0);
  EXPECT_NE(same.out.find("the same frames, id by id"), std::string::npos);
  const CommandResult text = Canlog("diff a.log b.asc", folder);
  EXPECT_EQ(text.exit_code, 1);
  const json run = Parsed(Canlog("diff a.log b.asc --json", folder), 1);
  EXPECT_EQ(run["same"], false);
  int differing = 0;
  for (const json& id : run["ids"]) {
    differing += id["first_difference"].is_null() ? 0 : 1;
    if (!id["first_difference"].is_null()) {
      EXPECT_EQ(run["parts_first"], id["id"]);
      EXPECT_NE(text.out.find("they part first with " + id["id"].get<std::string>()),
                std::string::npos);
    }
  }
  EXPECT_EQ(differing, 1);
  EXPECT_EQ(run["files"].size(), 2U);
  const CommandResult one = Canlog("diff a.log", folder);
  EXPECT_EQ(one.exit_code, 2);
  EXPECT_NE(one.error.find("diff: 1 files given; it takes two"), std::string::npos);
}

TEST(CanlogCommand, TakesOptionsBeforeFilesAndMoreThanOnce) {
  const fs::path folder = TestFolder();
  const std::string file = " '" + kStartup + "' ";
  EXPECT_EQ(Parsed(Canlog("--json --id 601 --id 581" + file, folder))["all"]["frames"], 64);
  EXPECT_EQ(Parsed(Canlog("--json --id 601" + file + file, folder))["all"]["frames"], 64);
  EXPECT_EQ(Canlog("decode --signal code --signal mode" + file, folder).out,
            "1795305883.549384  vcan1   081  emergency 1              code=heartbeat lost\n");
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    lines.push_back(line);
  }
  return lines;
}

TEST(CanlogExport, PrintsATableOfTheSignalsThatTheLogHas) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "a.log",
            "(1.000000) can1 111#01F4000000000000\n"
            "(1.020001) can1 111#01F4FED400000000\n"
            "(1.020000) can0 421#01\n"    // out of order, as two channels are
            "(1.030000) can0 211#0001\n"  // too short
            "(1.040000) can0 421#00\n");
  EXPECT_EQ(Lines(Canlog("a.log export", folder).out),
            (std::vector<std::string>{
                "t_s,base_twist_command/v [m/s],base_twist_command/omega [rad/s],"
                "base_state/vehicle_state,base_state/control_mode,base_state/battery [V],"
                "base_state/errors,base_state/count,base_mode_request/mode",
                "1.000000,0.5,0,,,,,,", "1.020000,,,,,,,,1", "1.020001,0.5,-0.3,,,,,,",
                "1.040000,,,,,,,,0"}));
  EXPECT_EQ(
      Lines(Canlog("a.log export --signal v,omega,mode --every 0.02", folder).out),
      (std::vector<std::string>{"t_s,base_twist_command/v [m/s],base_twist_command/omega [rad/s],"
                                "base_mode_request/mode",
                                "1.000000,0.5,0,", "1.020000,0.5,0,1", "1.040000,0.5,-0.3,0"}));
}

// What is in the file is tested by mcap_by_spec.py.
TEST(CanlogExport, WritesAnMcapFileAndNamesItsTopics) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "a.log",
            "(1.000000) can1 111#01F4000000000000\n(1.000000) can0 111#01F4000000000000\n"
            "(1.000000) can0 181#0000000000000000\n(1.000000) can0 111#01F4000000000000\n");
  const json run = Parsed(Canlog("a.log export --mcap a.mcap --json", folder));
  EXPECT_EQ(run["bytes"], fs::file_size(folder / "a.mcap"));
  EXPECT_EQ(run["frames"], 4);
  EXPECT_EQ(run["topics"], json::parse(R"([
      {"topic": "/cmd_vel", "type": "geometry_msgs/msg/TwistStamped", "messages": 1},
      {"topic": "/can0/cmd_vel", "type": "geometry_msgs/msg/TwistStamped", "messages": 2},
      {"topic": "/joint_states", "type": "sensor_msgs/msg/JointState", "messages": 1}])"));
  const CommandResult text = Canlog("a.log export --mcap a.mcap", folder);
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_NE(text.out.find("/can0/cmd_vel                     2  geometry_msgs/msg/TwistStamped\n"),
            std::string::npos)
      << text.out;
}

TEST(CanlogExport, WritesNoMcapFileOfWhatItCannotRead) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "a.log", "(1.000000) can1 111#01F4000000000000\n");
  EXPECT_EQ(Canlog("none.log export --mcap out.mcap", folder).exit_code, 2);
  EXPECT_FALSE(fs::exists(folder / "out.mcap"));
  const CommandResult both = Canlog("a.log export --mcap out.mcap --every 1", folder);
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_NE(both.error.find("goes without --every and --signal"), std::string::npos);
  const CommandResult nowhere = Canlog("a.log export --mcap nowhere/out.mcap", folder);
  EXPECT_EQ(nowhere.exit_code, 1);
  EXPECT_NE(nowhere.error.find("nowhere/out.mcap: cannot be written: No such file or directory"),
            std::string::npos);
  const CommandResult full = Canlog("a.log export --mcap /dev/full", folder);
  EXPECT_EQ(full.exit_code, 1);
  EXPECT_NE(full.error.find("No space left on device"), std::string::npos);
}

TEST(CanlogExport, NamesTheChannelWhereAnIdIsOnSeveral) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "a.log", "(1.000000) can1 421#01\n(1.000000) can0 421#02\n");
  EXPECT_EQ(Lines(Canlog("a.log export", folder).out),
            (std::vector<std::string>{"t_s,can1/base_mode_request/mode,can0/base_mode_request/mode",
                                      "1.000000,1,2"}));
  // Standard input is read once: every signal has its column, whatever the channel.
  const std::vector<std::string> lines =
      Lines(Canlog("- export --signal base_mode_request,base_error_reset <a.log", folder).out);
  EXPECT_EQ(lines, (std::vector<std::string>{"t_s,base_mode_request/mode,base_error_reset/what",
                                             "1.000000,2,"}));
}

}  // namespace
}  // namespace pipewright::hil
