// SPDX-License-Identifier: MIT
#include "hil/cli/run_figures.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "platform/core/rng.h"
#include "platform/robot/uf7.h"
#include "tests/support/post_cell.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

TEST(Percentile, IsTheSmallestValueThatTheShareDoesNotExceed) {
  const struct {
    std::vector<float> values;
    double p;
    double expected;
  } cases[] = {
      {{}, 0.5, 0},
      {{7}, 0, 7},
      {{7}, 0.5, 7},
      {{7}, 1, 7},
      {{3, 1, 2}, 0.5, 2},
      {{4, 3, 1, 2}, 0.5, 2},
      {{4, 3, 1, 2}, 0.51, 3},
      {{4, 3, 1, 2}, 0, 1},
      {{4, 3, 1, 2}, 1, 4},
      {{5, 5, 5, 9}, 0.75, 5},
      {{5, 5, 5, 9}, 0.99, 9},
  };
  for (const auto& c : cases) {
    EXPECT_EQ(Percentile(c.values, c.p), c.expected) << c.values.size() << " values, p " << c.p;
  }
}

TEST(Percentile, AgreesWithItsDefinitionByCounting) {
  Rng rng(5);
  for (int n = 1; n <= 60; ++n) {
    std::vector<float> values;
    for (int i = 0; i < n; ++i) {
      values.push_back(static_cast<float>(static_cast<int>(rng.Uniform(0, 20))));
    }
    for (const double p : {0.1, 0.25, 0.5, 0.9, 0.99}) {
      const double found = Percentile(values, p);
      int below = 0;
      int up_to = 0;
      for (const float value : values) {
        below += value < found;
        up_to += value <= found;
      }
      EXPECT_GE(up_to, p * n) << n << " " << p;
      EXPECT_LT(below, p * n) << n << " " << p;
    }
  }
}

TEST(RunFigures, AddUpWhatTheCyclesDid) {
  RunFigures figures;
  ControlReport report;
  report.stats.rows = 12;
  report.stats.qp_ns = 4500;
  report.stats.qp.iterations = 9;
  report.stats.qp.checked = 10;
  report.stats.qp.held = 8;
  report.stats.qp.fallbacks = 1;
  report.stats.qp.out_of_reach = true;
  figures.Add(report);
  report.stats.rows = 7;
  report.stats.qp_ns = 500;
  report.stats.qp.iterations = 3;
  report.stats.qp.status = QpStatus::kCapped;
  figures.Add(report);
  EXPECT_EQ(figures.cycles, 2U);
  EXPECT_EQ(figures.qp_iterations_max, 9);
  EXPECT_EQ(figures.qp_cap_hits, 1U);
  EXPECT_EQ(figures.svfi_checked, 20U);
  EXPECT_EQ(figures.svfi_held, 16U);
  EXPECT_EQ(figures.svfi_fallbacks, 2U);
  EXPECT_EQ(figures.svfi_out_of_reach, 2U);
  EXPECT_EQ(figures.rows_max, 12);
  EXPECT_EQ(figures.qp_us, (std::vector<float>{4.5F, 0.5F}));
}

class RunJsonTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(setenv("XDG_CACHE_HOME", (testing::TempDir() + "run_figures_cache").c_str(), 1), 0);
    const ScenarioResult result = ParseScenario(test::kPostCell, "cell", "");
    ASSERT_TRUE(result.scenario) << result.errors[0];
    options_.seed = 42;
    options_.faults = "/faults/dust.toml";
    options_.svfi = SvfiMode::kWorstCase;
    options_.joint_risk = true;
    options_.alpha = 0.8;
    program_ =
        std::make_unique<RobotProgram>(ProgramConfig(*result.scenario, options_), TracerUf7());
    emulator_ = std::make_unique<Emulator>(*result.scenario, HomeJoints(TracerUf7()), 1,
                                           std::vector<Port*>{&port_});
    figures_.cycles = 1000;
    figures_.svfi_checked = 40;
    figures_.svfi_held = 30;
    figures_.cycle_us = {1, 2, 3, 4};
    figures_.step_ms = {50, 20, 30};
    figures_.wall_s = 2.5;
    figures_.interrupted = Time{std::chrono::milliseconds(9250)};
    run_ = RunJson(options_, *result.scenario, *program_, emulator_.get(), figures_,
                   {.tx = 11, .rx = 12, .dropped = 1, .load_peak = 0.25},
                   Time{std::chrono::milliseconds(10000)}, "nothing");
  }

  InspectionOptions options_;
  can::LoopbackBus bus_{500'000};
  PortOf<can::LoopbackBus::Port> port_{*bus_.Attach()};
  std::unique_ptr<RobotProgram> program_;
  std::unique_ptr<Emulator> emulator_;
  RunFigures figures_;
  Json run_;
};

TEST_F(RunJsonTest, HasEveryKeyThatItsReadersCountOn) {
  const char* const kText[] = {"/scenario", "/planner", "/stop_reason", "/svfi/mode"};
  const char* const kNumbers[] = {"/seed",
                                  "/sim_time_s",
                                  "/interrupted_s",
                                  "/program/rate_hz",
                                  "/wall_time_s",
                                  "/voxels/total",
                                  "/voxels/free",
                                  "/voxels/occupied",
                                  "/voxels/unknown",
                                  "/voxels/residual",
                                  "/voxels/covered",
                                  "/coverage/truth_coverable",
                                  "/coverage/truth_covered",
                                  "/coverage/ratio",
                                  "/entropy/visual",
                                  "/entropy/coverage",
                                  "/entropy/combined",
                                  "/contacts",
                                  "/svfi/alpha",
                                  "/svfi/checked",
                                  "/svfi/held",
                                  "/svfi/ratio",
                                  "/control/cycles",
                                  "/control/heap_allocations",
                                  "/control/qp_iterations_max",
                                  "/control/qp_cap_hits",
                                  "/control/qp_us/p50",
                                  "/control/qp_us/p99",
                                  "/control/qp_us/max",
                                  "/control/cycle_us/p50",
                                  "/control/cycle_us/p99",
                                  "/control/cycle_us/max",
                                  "/control/lateral_speed_max_mps",
                                  "/plan/steps",
                                  "/plan/step_ms/p50",
                                  "/plan/step_ms/p99",
                                  "/plan/step_ms/max",
                                  "/path/base_m",
                                  "/path/joint_rad",
                                  "/can/tx",
                                  "/can/rx",
                                  "/can/dropped",
                                  "/can/load_peak"};
  for (const char* key : kText) {
    EXPECT_TRUE(run_.value(Json::json_pointer(key), Json()).is_string()) << key;
  }
  for (const char* key : kNumbers) {
    EXPECT_TRUE(run_.value(Json::json_pointer(key), Json()).is_number()) << key;
  }
  for (const char* key : {"plane", "pipe", "self"}) {  // null: nothing was ever near
    ASSERT_TRUE(run_["min_clearance_m"].contains(key)) << key;
    EXPECT_TRUE(run_["min_clearance_m"][key].is_number() || run_["min_clearance_m"][key].is_null());
  }
}

TEST_F(RunJsonTest, SaysWhatItWasGiven) {
  EXPECT_EQ(run_["scenario"], "cell");
  EXPECT_EQ(run_["faults"], "dust");
  EXPECT_EQ(run_["seed"], 42);
  EXPECT_EQ(run_["planner"], "cfnbv");
  EXPECT_EQ(run_["stop_reason"], "none");
  EXPECT_EQ(run_["sim_time_s"], 10.0);
  EXPECT_EQ(run_["wall_time_s"], 2.5);
  EXPECT_EQ(run_["svfi"]["mode"], "worst_case");
  EXPECT_EQ(run_["svfi"]["alpha"], 0.8);
  EXPECT_EQ(run_["svfi"]["joint_risk"], true);
  EXPECT_EQ(run_["svfi"]["ratio"], 0.75);
  EXPECT_EQ(run_["control"]["cycle_us"]["p50"], 2);
  EXPECT_EQ(run_["plan"]["step_ms"]["max"], 50);
  EXPECT_EQ(run_["can"]["dropped"], 1);
  // 12 x 12 x 12 voxels between bounds that lie on the grid.
  const Json& voxels = run_["voxels"];
  EXPECT_EQ(voxels["total"], voxels["free"].get<int>() + voxels["occupied"].get<int>() +
                                 voxels["unknown"].get<int>() + voxels["residual"].get<int>());
  EXPECT_GE(voxels["total"], 12 * 12 * 12);
  EXPECT_LE(voxels["total"], 13 * 13 * 13);
  // Nothing has been seen: ln 2 a voxel.
  EXPECT_NEAR(run_["entropy"]["visual"], 0.6931471805599453, 1e-9);
  EXPECT_EQ(run_["entropy"]["combined"], run_["entropy"]["visual"]);
  EXPECT_GT(run_["coverage"]["truth_coverable"], 0);
}

TEST_F(RunJsonTest, IsPlainJsonWhateverTheFigures) {
  EXPECT_EQ(Json::parse(run_.dump()), run_);
  EXPECT_EQ(run_.dump().find("inf"), std::string::npos);
  EXPECT_EQ(run_.dump().find("nan"), std::string::npos);
}

TEST_F(RunJsonTest, IsShownToPeopleAsATable) {
  const std::string table = RunTable(run_, "/tmp/evidence");
  for (const char* expected : {"none: nothing", "contacts", "10.0 s simulated in 2.5 s (4.0x)",
                               "11 frames out, 12 in, 1 dropped, load 25 %", "/tmp/evidence"}) {
    EXPECT_NE(table.find(expected), std::string::npos) << expected << " in\n" << table;
  }
}

// Nothing that was not measured here may look as if it had been.
TEST_F(RunJsonTest, TellsNothingOfATruthThatIsElsewhere) {
  const ScenarioResult result = ParseScenario(test::kPostCell, "cell", "");
  const Json run = RunJson(options_, *result.scenario, *program_, nullptr, RunFigures{}, {},
                           Time{std::chrono::milliseconds(10000)}, "");
  for (const char* key :
       {"/coverage", "/contacts", "/touched", "/min_clearance_m", "/control/lateral_speed_max_mps",
        "/control/joint_limit_excess_rad", "/control/joint_hard_stops", "/path/base_m",
        "/path/joint_rad", "/localization/error_max_m", "/localization/error_max_deg",
        "/localization/error_final_m", "/localization/error_final_deg",
        "/localization/wheels_error_max_m", "/localization/wheels_error_max_deg"}) {
    const Json::json_pointer pointer(key);
    ASSERT_TRUE(run.contains(pointer)) << key;
    EXPECT_TRUE(run[pointer].is_null()) << key << " is " << run[pointer];
    EXPECT_FALSE(run_[pointer].is_null()) << key << " where the truth is known";
  }
  const std::string table = RunTable(run, "/tmp/evidence");
  EXPECT_EQ(table.find("contacts"), std::string::npos) << table;
  EXPECT_NE(table.find("known where the devices are"), std::string::npos) << table;
}

TEST(Passed, OnlyWhenCompleteAndNothingTouchedAndNoHeap) {
  Json run = {{"stop_reason", "complete"}, {"contacts", 0}, {"control", {{"heap_allocations", 0}}}};
  EXPECT_TRUE(Passed(run));
  const std::pair<const char*, Json> kSpoilers[] = {
      {"/stop_reason", "timeout"}, {"/contacts", 1}, {"/control/heap_allocations", 3}};
  for (const auto& [key, value] : kSpoilers) {
    Json spoilt = run;
    spoilt[Json::json_pointer(key)] = value;
    EXPECT_FALSE(Passed(spoilt)) << key;
  }
  run["contacts"] = nullptr;  // whoever has the devices knows
  EXPECT_TRUE(Passed(run));
}

TEST(PlanJson, SaysWhatOneStepDecidedAndWhy) {
  MissionOutput output;
  output.plan_steps = 3;
  output.decision = PlanDecision::kGoal;
  output.numbers.candidates = 12;
  output.numbers.gain_visual = 1.5;
  Goal goal;
  goal.id = 9;
  goal.p_WS = {1, 2, 3};
  const Json step = PlanJson(Time{std::chrono::milliseconds(1500)}, output, goal, {.free = 4});
  EXPECT_EQ(step["t_s"], 1.5);
  EXPECT_EQ(step["step"], 3);
  EXPECT_EQ(step["decision"], Name(PlanDecision::kGoal));
  EXPECT_EQ(step["goal"]["id"], 9);
  EXPECT_EQ(step["goal"]["p_WS"], Json({1.0, 2.0, 3.0}));
  EXPECT_EQ(step["candidates"], 12);
  EXPECT_EQ(step["gain"]["visual"], 1.5);
  EXPECT_EQ(step["voxels"]["free"], 4);
  output.decision = PlanDecision::kComplete;
  const Json last = PlanJson(Time{}, output, goal, {});
  EXPECT_FALSE(last.contains("goal"));
  EXPECT_TRUE(last.contains("stopping"));
}

}  // namespace
}  // namespace pipewright::hil
