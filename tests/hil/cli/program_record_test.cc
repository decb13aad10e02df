// SPDX-License-Identifier: MIT
#include "hil/cli/program_record.h"

#include <gtest/gtest.h>

#include "platform/core/rng.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

Scenario Shipped(const char* name) {
  ScenarioResult shipped = LoadScenario(name);
  EXPECT_TRUE(shipped.scenario);
  return *shipped.scenario;
}

/// run.json as a run writes it, as far as a replay reads it.
Json RunOf(const Scenario& scenario, const InspectionOptions& options) {
  return {{"seed", options.seed},
          {"planner", Name(options.planner)},
          {"program", ProgramJson(scenario, options)},
          {"interrupted_s", nullptr}};
}

/// Through text, as a file is.
RecordedProgramResult Reread(const Json& run) { return ReadProgram(Json::parse(run.dump(2))); }

TEST(ProgramRecord, GivesBackTheProgramOfEveryShippedScenario) {
  for (const ShippedToml& shipped : ShippedScenarios()) {
    SCOPED_TRACE(shipped.name);
    Scenario scenario = Shipped(std::string(shipped.name).c_str());
    scenario.start.x_m += 1.0 / 3;  // no short decimal
    InspectionOptions options;
    options.seed = 0xFFFF'FFFF'FFFF'FFF7;
    options.planner = PlannerKind::kCfnbvPaper;
    options.svfi = SvfiMode::kWorstCase;
    options.alpha = 0.1 + 0.7;
    options.scans_correct = false;
    options.joint_risk = true;
    options.rate_hz = 125;
    options.bus = "loopback-shared";
    options.time_limit_s = 77.25;
    const RecordedProgramResult read = Reread(RunOf(scenario, options));
    ASSERT_TRUE(read.program) << read.error;
    const RobotProgramConfig was = ProgramConfig(scenario, options);
    const RobotProgramConfig is = read.program->config();
    EXPECT_EQ(is.start_joints_rad, was.start_joints_rad);
    EXPECT_EQ(is.control.start.x_m, was.control.start.x_m);
    EXPECT_EQ(is.control.start.y_m, was.control.start.y_m);
    EXPECT_EQ(is.control.start.phi_rad, was.control.start.phi_rad);
    EXPECT_EQ(is.control.law.constraints.period_s, was.control.law.constraints.period_s);
    EXPECT_EQ(is.control.law.constraints.svfi, was.control.law.constraints.svfi);
    EXPECT_EQ(is.control.law.constraints.alpha, was.control.law.constraints.alpha);
    EXPECT_EQ(is.control.law.constraints.joint_risk, was.control.law.constraints.joint_risk);
    EXPECT_EQ(is.control.law.reached, was.control.law.reached);
    EXPECT_EQ(is.control.arm.cycle_ms, was.control.arm.cycle_ms);
    EXPECT_EQ(is.control.scans_correct, was.control.scans_correct);
    EXPECT_EQ(is.mapping.map.lo, was.mapping.map.lo);
    EXPECT_EQ(is.mapping.map.hi, was.mapping.map.hi);
    EXPECT_EQ(is.mapping.map.workspace_lo, was.mapping.map.workspace_lo);
    EXPECT_EQ(is.mapping.map.workspace_hi, was.mapping.map.workspace_hi);
    EXPECT_EQ(is.mapping.start_clearance_m, was.mapping.start_clearance_m);
    EXPECT_EQ(is.mapping.seed, was.mapping.seed);
    EXPECT_EQ(is.mapping.localize, was.mapping.localize);
    EXPECT_EQ(is.mission.planner, was.mission.planner);
    EXPECT_EQ(is.mission.seed, was.mission.seed);
    EXPECT_EQ(is.mission.mission_timeout, was.mission.mission_timeout);
    EXPECT_FALSE(read.program->interrupted);
  }
}

TEST(ProgramRecord, KnowsWhenTheRunWasInterrupted) {
  Json run = RunOf(Shipped("pipes1"), {});
  run["interrupted_s"] = 12.34;
  EXPECT_EQ(Reread(run).program->interrupted, Time{std::chrono::milliseconds(12340)});
  run.erase("interrupted_s");  // the head of a run that broke off
  EXPECT_FALSE(Reread(run).program->interrupted);
}

TEST(ProgramRecord, NamesTheKeyThatIsMissingOrWrong) {
  const Json good = RunOf(Shipped("pipes1"), {});
  const struct {
    const char* path;
    Json value;  ///< null: the key is taken out
    const char* told;
  } cases[] = {
      {"/seed", nullptr, "\"seed\" is missing"},
      {"/seed", -1, "\"seed\" is no whole number"},
      {"/planner", "greedy", "\"planner\" is 'greedy'"},
      {"/program", nullptr, "\"program.workspace.min_m\" is missing"},
      {"/program", 7, "\"program.workspace.min_m\" is missing"},
      {"/program/start/x_m", "near", "\"program.start.x_m\" is not from"},
      {"/program/start/joints_rad", {1, 2, 3}, "\"program.start.joints_rad\" is no list of 7"},
      {"/program/map/max_m", {1e3, 0, 0}, "\"program.map.max_m\" is not from"},
      {"/program/map/max_m", {50, 50, 50}, "\"program.map\" is no box of at most 10 m"},
      {"/program/workspace/max_m", {9, 9, 9}, "\"program.workspace\" is not inside"},
      {"/program/svfi", 3, "\"program.svfi\" is no text"},
      {"/program/alpha", 1.5, "\"program.alpha\" is not from 0.5"},
      {"/program/joint_risk", 1, "\"program.joint_risk\" is not true or false"},
      {"/program/rate_hz", 333, "333"},
      {"/program/bus", "", "bus"},
      {"/interrupted_s", "now", "\"interrupted_s\" is not from"},
  };
  for (const auto& c : cases) {
    Json run = good;
    const Json::json_pointer at(c.path);
    if (c.value.is_null()) {
      run.at(at.parent_pointer()).erase(at.back());
    } else {
      run[at] = c.value;
    }
    const RecordedProgramResult read = ReadProgram(run);
    EXPECT_FALSE(read.program) << c.path;
    EXPECT_NE(read.error.find(c.told), std::string::npos) << c.path << ": " << read.error;
  }
  Rng rng(5);  // and whatever byte is wrong, it is a program or an error
  const std::string text = good.dump();
  for (std::size_t at = 0; at < text.size(); ++at) {
    std::string damaged = text;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << rng.Index(8)));
    const RecordedProgramResult read = ReadProgram(Json::parse(damaged, nullptr, false));
    EXPECT_EQ(read.program.has_value(), read.error.empty()) << damaged;
  }
  for (const Json& none : {Json(nullptr), Json::array({1, 2}), Json("text")}) {
    EXPECT_FALSE(ReadProgram(none).program);
  }
}

}  // namespace
}  // namespace pipewright::hil
