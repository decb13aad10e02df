// SPDX-License-Identifier: MIT
#include "hil/report/report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <sstream>

#include "hil/report/run_recorder.h"
#include "tests/hil/report/example_run.h"
#include "tests/hil/report/page.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

ReportInput Example(double slowness = 1) {
  ReportInput input;
  input.run = ExampleRun();
  for (const char* key : {"qp_us", "cycle_us"}) {
    input.run["control"][key]["max"] = 1234.5 * slowness;
  }
  input.run["wall_time_s"] = 33 * slowness;
  input.run["plan"]["step_ms"]["p50"] = 12 * slowness;
  input.plan = Json::array();
  for (int i = 1; i <= 200; ++i) {
    input.plan.push_back(ExampleStep(i));
  }
  RunRecorder recorder({.base_mps = 0.4, .base_radps = 0.9, .joint_radps = 1, .period_us = 10000});
  for (int i = 0; i < 24000; ++i) {
    const double t_s = 0.01 * i;
    const double wave = std::sin(37.0 * t_s) * std::sin(0.3 * t_s);
    CycleSample cycle;
    cycle.true_plane_m = cycle.true_pipe_m = cycle.true_self_m = 0.2 + 0.1 * wave;
    cycle.seen_plane_m = cycle.seen_pipe_m = cycle.seen_obstacle_m = 0.3 + 0.1 * wave;
    cycle.task_error = 1 + wave;
    cycle.base_mps = cycle.base_radps = 0.4 * wave;
    cycle.joint_radps.fill(wave);
    cycle.rows = 50 + std::floor(30 * wave);
    cycle.qp_iterations = std::floor(5 + 5 * wave);
    cycle.qp_us = slowness * (20 + 10 * wave);
    cycle.cycle_us = slowness * (40 + 10 * wave);
    recorder.Cycle(t_s, cycle);
    recorder.Map(t_s, {.coverage_ratio = t_s / 240,
                       .free = 17000 * t_s / 240,
                       .p_WP = Vector3d(0.7 + 0.3 * wave, 0.5 + 0.002 * t_s, 0.7)});
  }
  input.plots = recorder.Plots();
  input.world.min_m = Vector3d(0.1, 0.1, 0.1);
  input.world.max_m = Vector3d(1.4, 1.4, 1.4);
  for (int i = 0; i < 400; ++i) {
    input.world.surface.push_back({{2 + i % 20, 2 + i / 20, 5}, SurfaceState::kCovered});
  }
  input.world.hand_path = recorder.hand_path();
  return input;
}

void KeysOf(const Json& json, const std::string& at, std::vector<std::string>& keys) {
  if (!json.is_object()) {
    keys.push_back(at);
    return;
  }
  for (const auto& [key, value] : json.items()) {
    KeysOf(value, at.empty() ? key : at + "." + key, keys);
  }
}

TEST(Report, IsWellFormedAndNamesEveryKeyOfTheRun) {
  const Page page(RenderReport(Example()));
  std::set<std::string> codes;
  for (const tinyxml2::XMLElement* code : page.Named("code")) {
    codes.insert(Page::Text(*code));
  }
  std::vector<std::string> keys;
  KeysOf(ExampleRun(), "", keys);
  EXPECT_GT(keys.size(), 50u);
  for (const std::string& key : keys) {
    EXPECT_TRUE(codes.contains(key)) << key;
  }
}

TEST(Report, NeedsNothingButItself) {
  const std::string html = RenderReport(Example());
  EXPECT_LT(html.size(), 500000u);
  EXPECT_EQ(html.find("{{"), std::string::npos);
  const Page page(html);
  for (const char* name : {"script", "link", "img", "iframe", "object", "embed", "use"}) {
    EXPECT_TRUE(page.Named(name).empty()) << name;
  }
  for (const char* text : {"url(", "@import", "src="}) {
    EXPECT_EQ(html.find(text), std::string::npos) << text;
  }
  for (const tinyxml2::XMLElement* a : page.Named("a")) {
    const std::string target = a->Attribute("href");
    ASSERT_EQ(target.at(0), '#');
    EXPECT_EQ(page.All([&](const tinyxml2::XMLElement& e) {
                    return e.Attribute("id", target.c_str() + 1) != nullptr;
                  })
                  .size(),
              1u);
  }
}

TEST(Report, ShowsForeignTextAsText) {
  const std::string bad = "<script>alert('&\"')</script>{{plots}}";
  ReportInput input;
  input.run = {{"scenario", bad}, {"planner", bad},        {"stop_reason", bad},
               {bad, bad},        {"touched", {bad, "x"}}, {"stop_detail", bad}};
  input.plan = Json::array({Json{{"step", 1}, {"decision", bad}}});
  input.plots = {{.title = bad, .series = {{bad, {0, 1}, {0, 1}}}}};
  const Page page(RenderReport(input));
  EXPECT_TRUE(page.Named("script").empty());
  EXPECT_EQ(Page::Text(*page.Named("h1").at(0)), std::string("Inspection of ").append(bad));
  EXPECT_EQ(page.OfClass("plot").size(), 1u);
}

TEST(Report, StandsWithoutARun) {
  const Page nothing(RenderReport({}));
  EXPECT_EQ(nothing.OfClass("verdict").size(), 1u);
  ReportInput input;
  input.run = {{"scenario", "pipes1"}, {"seed", 3}, {"stop_reason", "running"}};
  const Page head(RenderReport(input));
  EXPECT_EQ(Page::Text(*head.Named("h1").at(0)), "Inspection of pipes1");
  EXPECT_TRUE(Page::HasClass(*head.OfClass("verdict").at(0), "missed"));
}

TEST(Report, OnlyLinesOfClassWallDependOnTheWallClock) {
  const std::string fast = RenderReport(Example(1));
  const std::string slow = RenderReport(Example(7));
  EXPECT_EQ(fast, RenderReport(Example(1)));
  std::istringstream a(fast);
  std::istringstream b(slow);
  std::string line_a;
  std::string line_b;
  int different = 0;
  while (std::getline(a, line_a) && std::getline(b, line_b)) {
    if (line_a != line_b) {
      ++different;
      const std::string head = line_a.substr(0, line_a.find('>'));
      EXPECT_TRUE(head.find("wall\"") != std::string::npos) << head;
      EXPECT_EQ(head, line_b.substr(0, line_b.find('>')));
    }
  }
  EXPECT_EQ(a.eof(), true);
  EXPECT_FALSE(std::getline(b, line_b));
  EXPECT_EQ(different, 5);  // wall_time_s, two maxima, one median, one plot
}

}  // namespace
}  // namespace pipewright::hil
