// SPDX-License-Identifier: MIT
#include "hil/report/markup.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pipewright::hil {
namespace {

TEST(Escape, LeavesNothingThatIsMarkup) {
  EXPECT_EQ(Escape("<a href=\"x\">&'"), "&lt;a href=&quot;x&quot;&gt;&amp;&#39;");
  EXPECT_EQ(Escape("rør — 管"), "rør — 管");
  EXPECT_EQ(Escape(std::string_view("a\0b\x1b", 4)), "a\uFFFDb\uFFFD");
  EXPECT_EQ(Escape("a\tb\n"), "a\tb\n");
}

TEST(Number, IsReadable) {
  struct Case {
    double value;
    const char* text;
  };
  constexpr Case kCases[] = {
      {0, "0"},
      {-0.0, "0"},
      {7, "7"},
      {-7, "−7"},
      {1234, "1234"},
      {17576, "17\u202F576"},
      {1234567, "1\u202F234\u202F567"},
      {0.0943698, "0.09437"},
      {98.2353, "98.24"},
      {12345.678, "12\u202F346"},
      {999.97, "1000"},
      {7.7947e-14, "7.795e−14"},
      {-2e-5, "−2e−5"},
      {1e300, "1e300"},
  };
  for (const Case& c : kCases) {
    EXPECT_EQ(Number(c.value), c.text);
  }
  EXPECT_EQ(Number(NAN), "–");
  EXPECT_EQ(Number(INFINITY), "–");
}

TEST(Fill, PutsEachTextInItsPlacesOnce) {
  EXPECT_EQ(Fill("a{{x}}b{{y}}{{x}}", {{"x", "1"}, {"y", "{{x}}"}}), "a1b{{x}}1");
  EXPECT_EQ(Fill("{{unknown}} {{", {{"x", "1"}}), "{{unknown}} {{");
  EXPECT_EQ(Fill("", {}), "");
}

}  // namespace
}  // namespace pipewright::hil
