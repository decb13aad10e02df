// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "hil/world/scenario.h"
#include "tests/support/command.h"

namespace pipewright::test {

using Json = nlohmann::ordered_json;

inline std::string ShippedText(const std::string& name) {
  for (const hil::ShippedToml& shipped : hil::ShippedScenarios()) {
    if (shipped.name == name) {
      return std::string(shipped.toml);
    }
  }
  ADD_FAILURE() << "no scenario " << name;
  return "";
}

struct MissionRun {
  int exit_code = -1;
  std::string error;
  Json run;                      ///< what --json printed; discarded when it was none
  std::filesystem::path folder;  ///< the evidence
};

/// Runs `pipewright inspect --json` on a scenario of this text in a folder of its own, `name`.
inline MissionRun RunMission(const std::filesystem::path& base, const std::string& name,
                             const std::string& scenario, const std::string& options) {
  const std::filesystem::path place = base / name;
  std::filesystem::create_directories(place);
  WriteFile(place / "cell.toml", scenario);
  const CommandResult result = RunCommand(
      PIPEWRIGHT_BINARY, "inspect --scenario cell.toml --out evidence --json " + options, place);
  return {result.exit_code, result.error,
          Json::parse(result.out, nullptr, /*allow_exceptions=*/false), place / "evidence"};
}

inline std::vector<std::string> LinesOf(const std::filesystem::path& path) {
  std::vector<std::string> lines;
  std::istringstream in(ReadFile(path));
  for (std::string line; std::getline(in, line);) {
    lines.push_back(line);
  }
  return lines;
}

/// Every file is there and whole, and speaks of the run up to its end.
inline void ExpectWholeFolder(const MissionRun& mission) {
  const std::filesystem::path& folder = mission.folder;
  ASSERT_TRUE(mission.run.is_object()) << mission.error;
  EXPECT_EQ(Json::parse(ReadFile(folder / "run.json")), mission.run);
  const double end_s = mission.run["sim_time_s"];

  const std::vector<std::string> trace = LinesOf(folder / "trace.csv");
  ASSERT_GT(trace.size(), 1U);
  EXPECT_EQ(trace.size() - 1, mission.run["control"]["cycles"]);
  EXPECT_NEAR(std::stod(trace.back()), end_s, 0.05);
  const auto commas = [](const std::string& line) {
    return std::count(line.begin(), line.end(), ',');
  };
  EXPECT_EQ(commas(trace.front()), commas(trace.back()));

  const std::vector<std::string> can = LinesOf(folder / "can.log");
  ASSERT_FALSE(can.empty());
  EXPECT_NEAR(std::stod(can.back().substr(1)), end_s, 0.2);

  const std::vector<std::string> plan = LinesOf(folder / "plan.jsonl");
  EXPECT_EQ(plan.size(), mission.run["plan"]["steps"]);
  for (const std::string& line : plan) {
    EXPECT_TRUE(Json::parse(line, nullptr, false).is_object()) << line;
  }
  EXPECT_EQ(ReadFile(folder / "map.bt").substr(0, 28), "# Octomap OcTree binary file");
  EXPECT_EQ(ReadFile(folder / "map.ot").substr(0, 21), "# Octomap OcTree file");
  EXPECT_NE(ReadFile(folder / "report.html").find("</html>"), std::string::npos);
}

}  // namespace pipewright::test
