// SPDX-License-Identifier: MIT
#include "tests/bench/mission_figures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "platform/core/rng.h"
#include "tests/support/command.h"

namespace pipewright::bench {
namespace {

using Json = nlohmann::ordered_json;

TEST(RateBound95, IsClopperAndPearsons) {
  // By bisection of the binomial's sum in exact binomial coefficients.
  const struct {
    int k;
    int n;
    double bound;
  } cases[] = {
      {0, 1, 0.95},
      {0, 3, 0.6315968501359613},
      {0, 100, 0.02951304960703999},
      {1, 20, 0.2161061642068473},
      {5, 10, 0.777558898991871},
      {19, 20, 0.9974386212234698},
      {3, 300, 0.025641393082609657},
      {150, 300, 0.5489912452912066},
      {2, 1000, 0.006282284546723472},
  };
  for (const auto& c : cases) {
    EXPECT_NEAR(RateBound95(c.k, c.n), c.bound, 1e-11) << c.k << " of " << c.n;
  }
  for (const int n : {0, 1, 7}) {
    EXPECT_EQ(RateBound95(n, n), 1) << "all of " << n;
  }
}

TEST(RateBound95, LeavesFivePercentToAsFewEvents) {
  for (int n = 1; n <= 60; ++n) {
    for (int k = 0; k < n; ++k) {
      const double p = RateBound95(k, n);
      double term = std::pow(1 - p, n);
      double sum = term;
      for (int i = 1; i <= k; ++i) {
        term *= (n - i + 1.0) / i * p / (1 - p);
        sum += term;
      }
      EXPECT_NEAR(sum, 0.05, 1e-9) << k << " of " << n;
    }
  }
}

TEST(MissionRun, TellsUnlessItWasLostOrCutShortBeforeAContact) {
  const struct {
    const char* stop;
    bool read;
    int contacts;
    bool tells;
  } cases[] = {
      {"complete", true, 0, true},      {"timeout", true, 3, true},
      {"interrupted", true, 0, false},  {"interrupted", true, 1, true},
      {"interrupted", false, 0, false}, {"crashed", false, 0, false},
      {"refused", false, 0, false},
  };
  for (const auto& c : cases) {
    MissionRun run;
    run.stop = c.stop;
    run.read = c.read;
    run.contacts = c.contacts;
    EXPECT_EQ(run.tells(), c.tells) << c.stop << ", " << c.contacts << " contacts";
  }
}

/// Runs of every kind; only one that was read has figures.
std::vector<MissionRun> AnyRuns(int count, Rng* rng) {
  std::vector<MissionRun> runs(static_cast<std::size_t>(count));
  for (MissionRun& run : runs) {
    const char* const stops[] = {"complete", "timeout", "interrupted", "crashed"};
    run.stop = stops[rng->Index(4)];
    run.read = run.stop != "crashed" && (run.stop != "interrupted" || rng->Index(2) > 0);
    if (run.read) {
      run.contacts = std::max(0, rng->Index(5) - 2);
      run.error_max_m = rng->Uniform(0, 0.1);
      run.error_final_deg = rng->Index(3);
      run.heap_allocations = static_cast<std::uint64_t>(rng->Index(4));
    }
  }
  return runs;
}

TEST(Summary, IsWhatCountingByHandGives) {
  Rng rng(3);
  for (int n = 0; n < 60; ++n) {
    const std::vector<MissionRun> runs = AnyRuns(n % 12, &rng);
    const Json summary = Summary(runs);
    std::map<std::string, int> stops;
    std::vector<double> errors_mm;
    std::vector<double> errors_deg;
    int contacts = 0;
    int touched = 0;
    int tell = 0;
    std::uint64_t allocations = 0;
    for (const MissionRun& run : runs) {
      ++stops[run.stop];
      contacts += run.contacts;
      touched += run.contacts > 0;
      allocations += run.heap_allocations;
      const bool ended = run.stop == "complete" || run.stop == "timeout";
      tell += ended || run.contacts > 0;
      if (ended) {
        errors_mm.push_back(1e3 * run.error_max_m);
        errors_deg.push_back(run.error_final_deg);
      }
    }
    EXPECT_EQ(summary["missions"], n % 12);
    EXPECT_EQ(summary["complete"], stops["complete"]);
    EXPECT_EQ(summary["crashed"], stops["crashed"]);
    EXPECT_EQ(summary["contacts"], contacts);
    EXPECT_EQ(summary["missions_with_contact"], touched);
    EXPECT_EQ(summary["missions_that_tell"], tell);
    EXPECT_EQ(summary["contact_rate_bound95"], RateBound95(touched, tell));
    EXPECT_EQ(summary["heap_allocations"], allocations);
    for (const auto& [name, values] :
         {std::pair{"error_max_mm", &errors_mm}, std::pair{"error_final_deg", &errors_deg}}) {
      if (values->empty()) {
        EXPECT_TRUE(summary[name]["median"].is_null() && summary[name]["max"].is_null());
        continue;
      }
      // The middle value: as many above as below; or the mean of the middle two.
      const auto size = static_cast<std::ptrdiff_t>(values->size());
      std::sort(values->begin(), values->end(), std::greater<>());
      const double median = 0.5 * ((*values)[size / 2] + (*values)[size - 1 - size / 2]);
      EXPECT_DOUBLE_EQ(summary[name]["median"].get<double>(), median);
      EXPECT_EQ(summary[name]["max"], values->front());
    }
    EXPECT_NE(SummaryLine("any", summary).find(std::to_string(touched) + " of "),
              std::string::npos);
  }
}

const char* const kWhole = R"({"stop_reason": "timeout", "stop_detail": "too late",
  "sim_time_s": 12.5, "contacts": 2, "coverage": {"ratio": 0.75}, "control": {"heap_allocations": 3},
  "localization": {"error_max_m": 0.25, "error_max_deg": 4, "error_final_m": 0.125,
                   "error_final_deg": 2}})";

/// What is read of a run.json with this text, or of none.
MissionRun Read(const std::filesystem::path& folder, const std::string* text) {
  const std::filesystem::path path = folder / "run.json";
  std::filesystem::remove(path);
  if (text != nullptr) {
    test::WriteFile(path, *text);
  }
  MissionRun run;
  run.seed = 7;
  ReadRun(path, run);
  return run;
}

/// Not read, and says why; no figure of it is taken over.
void ExpectUnread(const MissionRun& run, const std::string& of) {
  SCOPED_TRACE(of);
  EXPECT_FALSE(run.read);
  EXPECT_FALSE(run.detail.empty());
  EXPECT_EQ(run.stop, "");
  EXPECT_EQ(run.contacts, 0);
  EXPECT_EQ(run.sim_s, 0);
  EXPECT_EQ(run.seed, 7U);
}

TEST(ReadRun, TakesEveryFigureOver) {
  const std::string text = kWhole;
  const MissionRun run = Read(test::TestFolder(), &text);
  EXPECT_TRUE(run.read);
  EXPECT_EQ(run.stop, "timeout");
  EXPECT_EQ(run.detail, "too late");
  EXPECT_EQ(run.sim_s, 12.5);
  EXPECT_EQ(run.contacts, 2);
  EXPECT_EQ(run.coverage, 0.75);
  EXPECT_EQ(run.error_max_m, 0.25);
  EXPECT_EQ(run.error_max_deg, 4);
  EXPECT_EQ(run.error_final_m, 0.125);
  EXPECT_EQ(run.error_final_deg, 2);
  EXPECT_EQ(run.heap_allocations, 3U);
  EXPECT_EQ(run.seed, 7U);
}

TEST(ReadRun, LeavesARunUnreadWhoseFileIsMissingOrCutAnywhere) {
  const std::filesystem::path folder = test::TestFolder();
  ExpectUnread(Read(folder, nullptr), "no file");
  const std::string whole = kWhole;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const std::string cut = whole.substr(0, length);
    ExpectUnread(Read(folder, &cut), cut);
  }
}

TEST(ReadRun, LeavesARunUnreadThatLacksAKeyOrHasAnotherKindOfValue) {
  const std::filesystem::path folder = test::TestFolder();
  const Json whole = Json::parse(kWhole).flatten();
  for (const auto& [key, value] : whole.items()) {
    Json lacking = whole;
    lacking.erase(key);
    Json wrong = whole;
    wrong[key] = nullptr;  // what a figure that is not a number becomes
    for (const Json& json : {lacking, wrong}) {
      const std::string text = json.unflatten().dump();
      ExpectUnread(Read(folder, &text), text);
    }
  }
  for (const std::string text : {"null", "[]", "7", R"({"stop_reason": "running"})"}) {
    ExpectUnread(Read(folder, &text), text);
  }
}

}  // namespace
}  // namespace pipewright::bench
