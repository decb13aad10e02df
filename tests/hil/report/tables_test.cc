// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "hil/report/figure_tables.h"
#include "hil/report/plan_table.h"
#include "tests/hil/report/example_run.h"
#include "tests/hil/report/page.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

/// The cells of each row whose first one is a key.
std::vector<std::vector<std::string>> RowsOf(const std::string& html) {
  const Page page("<div>" + html + "</div>");
  std::vector<std::vector<std::string>> rows;
  for (const tinyxml2::XMLElement* row : page.Named("tr")) {
    std::vector<std::string> cells;
    for (auto* cell = row->FirstChildElement(); cell != nullptr;
         cell = cell->NextSiblingElement()) {
      cells.push_back(Page::Text(*cell));
    }
    rows.push_back(cells);
  }
  return rows;
}

std::vector<std::string> RowOf(const Json& run, const std::string& key) {
  for (const std::vector<std::string>& row : RowsOf(RenderFigureTables(run))) {
    if (row.at(0) == key) {
      return row;
    }
  }
  ADD_FAILURE() << key << " is missing";
  return {"", "", "", ""};
}

TEST(FigureTables, HaveEachFigureWithValueAndUnit) {
  struct Case {
    const char* key;
    const char* value;
    const char* unit;
  };
  constexpr Case kCases[] = {
      {"scenario", "pipes3", ""},
      {"stop_detail", "–", ""},
      {"sim_time_s", "241.5", "s"},
      {"touched", "none", ""},
      {"voxels.total", "17\u202F576", "voxels"},
      {"coverage.ratio", "98.23", "%"},
      {"min_clearance_m.self", "0.02911", "m"},
      {"control.rate_hz", "100", "Hz"},
      {"control.qp_us.p99", "31", "µs"},
      {"plan.step_ms.max", "56.3", "ms"},
      {"control.lateral_speed_max_mps", "7.79e−14", "m/s"},
      {"localization.error_max_deg", "0.46", "°"},
      {"can.load_peak", "17.28", "%"},
  };
  for (const Case& c : kCases) {
    SCOPED_TRACE(c.key);
    const std::vector<std::string> row = RowOf(ExampleRun(), c.key);
    EXPECT_EQ(row.at(1), c.value);
    EXPECT_EQ(row.at(2), c.unit);
    EXPECT_EQ(row.size(), 4u);
  }
}

TEST(FigureTables, EveryKeyOfTheRunSaysWhatItIs) {
  for (const std::vector<std::string>& row : RowsOf(RenderFigureTables(ExampleRun()))) {
    EXPECT_FALSE(row.at(3).empty()) << row.at(0);
  }
}

TEST(FigureTables, ShowKeysTheyDoNotKnow) {
  const Json run = {{"new", {{"speed_radps", 1.5}, {"deep", {{"er_m", nullptr}}}}},
                    {"list", {"<floor>", "wall"}},
                    {"flag", true}};
  EXPECT_EQ(RowOf(run, "new.speed_radps"),
            (std::vector<std::string>{"new.speed_radps", "1.5", "rad/s", ""}));
  EXPECT_EQ(RowOf(run, "new.deep.er_m").at(1), "–");
  EXPECT_EQ(RowOf(run, "list").at(1), "<floor>, wall");
  EXPECT_EQ(RowOf(run, "flag").at(1), "true");
}

TEST(FigureTables, ShowTheFirstFewOfALongList) {
  Json run;
  run["places"] = Json::array();
  for (int i = 0; i < 300; ++i) {
    run["places"].push_back(Json::array({i, -1}));
  }
  const std::string text = RowOf(run, "places").at(1);
  EXPECT_TRUE(text.starts_with("(0, −1), (1, −1), ")) << text;
  EXPECT_NE(text.find("… 300 in all"), std::string::npos);
  EXPECT_LT(text.size(), 200u);
}

TEST(PlanTable, HasARowAStep) {
  Json plan = {ExampleStep(1), ExampleStep(2)};
  plan[1]["decision"] = "<complete>";
  plan[1].erase("goal");
  const auto rows = RowsOf(RenderPlanTable(plan));
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[1].size(), rows[0].size());
  EXPECT_EQ(rows[1].at(0), "1");
  EXPECT_EQ(rows[1].at(4), "0.19, 0.63, 0.53");
  EXPECT_EQ(rows[2].size(), rows[0].size());
  EXPECT_EQ(rows[2].at(2), "<complete>");
  EXPECT_EQ(rows[2].at(4), "");
}

TEST(PlanTable, OfVeryManyStepsShowsBothEnds) {
  Json plan = Json::array();
  for (int i = 1; i <= 1000; ++i) {
    plan.push_back(ExampleStep(i));
  }
  const auto rows = RowsOf(RenderPlanTable(plan));
  ASSERT_EQ(rows.size(), 402u);
  EXPECT_EQ(rows[200].at(0), "200");
  EXPECT_NE(rows[201].at(0).find("600 more"), std::string::npos);
  EXPECT_EQ(rows[202].at(0), "801");
  EXPECT_EQ(rows[401].at(0), "1000");
}

TEST(PlanTable, OfNothingSaysSo) {
  EXPECT_NE(RenderPlanTable(Json::array()).find("No planning step"), std::string::npos);
  EXPECT_NE(RenderPlanTable(Json()).find("No planning step"), std::string::npos);
}

TEST(GoalsOf, TakesThePlacesThatThereAre) {
  Json plan = {ExampleStep(1), ExampleStep(2), ExampleStep(3)};
  plan[1].erase("goal");
  plan[2]["goal"]["p_WS"] = "nowhere";
  const std::vector<Vector3d> goals = GoalsOf(plan);
  ASSERT_EQ(goals.size(), 1u);
  EXPECT_EQ(goals[0], Vector3d(0.186, 0.628, 0.528));
}

}  // namespace
}  // namespace pipewright::hil
