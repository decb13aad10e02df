// SPDX-License-Identifier: MIT
#include "hil/report/verdict.h"

#include <gtest/gtest.h>

#include "tests/hil/report/example_run.h"
#include "tests/hil/report/page.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;
using Result = Check::Result;

int CountOf(const std::vector<Check>& checks, Result result) {
  int count = 0;
  for (const Check& check : checks) {
    count += check.result == result;
  }
  return count;
}

TEST(Checks, AreAllMetByAGoodRun) {
  const std::vector<Check> checks = Checks(ExampleRun());
  EXPECT_GE(checks.size(), 10u);
  EXPECT_EQ(CountOf(checks, Result::kMet), static_cast<int>(checks.size()));
}

TEST(Checks, EachIsMissedByItsOwnFigureAlone) {
  struct Case {
    const char* pointer;
    Json value;
  };
  const Case cases[] = {
      {"/stop_reason", "timeout"},
      {"/contacts", 1},
      {"/coverage/ratio", 0.9499},
      {"/min_clearance_m/plane", 0.0},
      {"/min_clearance_m/pipe", 0.0},
      {"/min_clearance_m/self", -0.001},
      {"/control/joint_limit_excess_rad", 1e-6},
      {"/control/joint_hard_stops", 2},
      {"/control/lateral_speed_max_mps", 1e-9},
      {"/control/heap_allocations", 1},
      {"/can/dropped", 3},
  };
  EXPECT_EQ(std::size(cases), Checks(ExampleRun()).size());
  for (const Case& c : cases) {
    SCOPED_TRACE(c.pointer);
    Json run = ExampleRun();
    run[Json::json_pointer(c.pointer)] = c.value;
    EXPECT_EQ(CountOf(Checks(run), Result::kMissed), 1);
    const Page page("<div>" + RenderVerdict(run) + "</div>");
    EXPECT_TRUE(Page::HasClass(*page.OfClass("verdict").at(0), "missed"));
  }
}

TEST(Checks, TargetsThemselvesAreEnough) {
  Json run = ExampleRun();
  run["coverage"]["ratio"] = 0.95;
  run["control"]["joint_limit_excess_rad"] = 0.0;
  EXPECT_EQ(CountOf(Checks(run), Result::kMissed), 0);
}

TEST(Checks, NothingNearIsClearEnough) {
  Json run = ExampleRun();
  run["min_clearance_m"]["pipe"] = nullptr;
  EXPECT_EQ(CountOf(Checks(run), Result::kMissed), 0);
  EXPECT_EQ(CountOf(Checks(run), Result::kNotMeasured), 0);
}

TEST(Checks, AClearanceThatNobodyKnowsIsNotMet) {
  Json run = ExampleRun();
  for (const char* key : {"coverage", "contacts", "min_clearance_m"}) {
    run[key] = nullptr;
  }
  EXPECT_EQ(CountOf(Checks(run), Result::kMissed), 0);
  EXPECT_EQ(CountOf(Checks(run), Result::kNotMeasured), 5);
}

TEST(Checks, AFigureThatIsNotThereIsNotMet) {
  const Json head = {{"scenario", "pipes1"}, {"stop_reason", "running"}};
  const std::vector<Check> checks = Checks(head);
  EXPECT_EQ(CountOf(checks, Result::kMissed), 1);
  EXPECT_EQ(CountOf(checks, Result::kNotMeasured), static_cast<int>(checks.size()) - 1);
  EXPECT_EQ(CountOf(Checks(Json()), Result::kMet), 0);
}

TEST(Verdict, SaysWhatStoppedTheMission) {
  Json run = ExampleRun();
  run["stop_reason"] = "device_fault";
  run["stop_detail"] = "arm joint 3: <silent> & gone";
  const Page page("<div>" + RenderVerdict(run) + "</div>");
  const std::string reason = Page::Text(*page.OfClass("reason").at(0));
  EXPECT_NE(reason.find("device_fault"), std::string::npos);
  EXPECT_NE(reason.find("arm joint 3: <silent> & gone"), std::string::npos);
}

TEST(Verdict, ShowsTheSmallestClearanceOfAll) {
  const Page page("<div>" + RenderVerdict(ExampleRun()) + "</div>");
  std::string tiles;
  for (const tinyxml2::XMLElement* e : page.OfClass("tile")) {
    tiles += Page::Text(*e) + "|";
  }
  EXPECT_NE(tiles.find("29.11\u00A0mmsmallest clearance, to itself"), std::string::npos) << tiles;
}

}  // namespace
}  // namespace pipewright::hil
