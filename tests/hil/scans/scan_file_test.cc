// SPDX-License-Identifier: MIT
#include "hil/scans/scan_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/command.h"
#include "tests/support/scan_bytes.h"

namespace pipewright::hil {
namespace {

using Eigen::Vector3f;
using test::RaysFile;
using test::ScansFile;
using test::TestFolder;
using test::ViewsFile;

std::filesystem::path FileOf(const std::string& bytes) {
  static const std::filesystem::path folder = TestFolder();
  const std::filesystem::path path = folder / "set.bin";
  std::filesystem::create_directories(folder);
  test::WriteFile(path, bytes);
  return path;
}

TEST(ScanFile, GivesWhatWasWritten) {
  const auto scans = ReadScans(FileOf(ScansFile({1, 2, 3}, {{4, 5, 6, 7, 8, NAN}, {}}, 2.5F)));
  ASSERT_TRUE(scans.content) << scans.error;
  EXPECT_EQ(scans.content->width_m, 0.05) << "the decimal that was meant, not the float";
  EXPECT_EQ(scans.content->max_range_m, 2.5);
  ASSERT_EQ(scans.content->scans.size(), 2U);
  EXPECT_EQ(scans.content->scans[0].origin_W, Vector3f(1, 2, 3));
  ASSERT_EQ(scans.content->scans[0].points_W.size(), 2U);
  EXPECT_EQ(scans.content->scans[0].points_W[0], Vector3f(4, 5, 6));
  EXPECT_TRUE(std::isnan(scans.content->scans[0].points_W[1].z()));
  EXPECT_TRUE(scans.content->scans[1].points_W.empty());

  const auto views = ReadViews(FileOf(ViewsFile({1, 2, 3}, {1, 0, 0, 0, 1, 0}, {0, 0, 1})));
  ASSERT_TRUE(views.content) << views.error;
  EXPECT_EQ(views.content->visual_range_m, 3.0F);
  EXPECT_EQ(views.content->coverage_range_m, 0.4F);
  ASSERT_EQ(views.content->views.size(), 1U);
  EXPECT_EQ(views.content->views[0].p_W, Vector3f(1, 2, 3));
  EXPECT_EQ(views.content->views[0].visual_W[1], Vector3f(0, 1, 0));
  EXPECT_EQ(views.content->views[0].coverage_W[0], Vector3f(0, 0, 1));

  const auto rays = ReadRays(FileOf(RaysFile(-1, {{1, 2, 3, 4, 5, 6}})));
  ASSERT_TRUE(rays.content) << rays.error;
  EXPECT_EQ(rays.content->max_range_m, -1);
  ASSERT_EQ(rays.content->rays.size(), 1U);
  EXPECT_EQ(rays.content->rays[0].origin_W, Vector3f(1, 2, 3));
  EXPECT_EQ(rays.content->rays[0].direction_W, Vector3f(4, 5, 6));
}

TEST(ScanFile, SaysInWhichByteOfWhichFileItIsWrong) {
  const std::string good = ScansFile({1, 2, 3}, {{4, 5, 6}});
  std::string many = good;
  many[83] = 0x10;  // the count of points at byte 80 becomes huge
  std::string none = good;
  none[4] = 0;
  const struct {
    const char* what;
    std::string bytes;
    const char* expected;
  } cases[] = {
      {"empty", "", "set.bin: is cut short at byte 0: its first four bytes begins at byte 0"},
      {"another format", RaysFile(1, {}), "set.bin: is not MPC1"},
      {"no scans", none, "the number of scans is 0 (byte 4)"},
      {"cut in its points", good.substr(0, 90),
       "is cut short at byte 90: scan 0: its points begins at byte 84"},
      {"more points than bytes", many, "is cut short at byte 96: scan 0: its points"},
      {"something behind", good + "xy", "has 2 bytes too many, from byte 96 on"},
      {"no origin", ScansFile({1, NAN, 3}, {{}}), "scan 0: its origin is not a number (byte 36)"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    const auto read = ReadScans(FileOf(c.bytes));
    EXPECT_FALSE(read.content);
    EXPECT_NE(read.error.find(c.expected), std::string::npos) << read.error;
  }
  EXPECT_NE(ReadScans("/none/such").error.find("/none/such: no such file"), std::string::npos);
  EXPECT_NE(ReadScans("/dev/null").error.find("is not a file"), std::string::npos);
  EXPECT_NE(ReadViews(FileOf(good)).error.find("is not MPV1"), std::string::npos);
  EXPECT_NE(ReadRays(FileOf(good)).error.find("is not MPR1"), std::string::npos);
}

TEST(ScanFile, TakesNoFileThatEndsEarly) {
  for (const std::string& good :
       {ScansFile({1, 2, 3}, {{4, 5, 6}, {7, 8, 9}}), ViewsFile({1, 2, 3}, {1, 0, 0}, {0, 0, 1}),
        RaysFile(1, {{1, 2, 3, 4, 5, 6}})}) {
    for (std::size_t size = 0; size < good.size(); ++size) {
      const std::filesystem::path path = FileOf(good.substr(0, size));
      EXPECT_FALSE(ReadScans(path).content || ReadViews(path).content || ReadRays(path).content)
          << size;
    }
  }
}

}  // namespace
}  // namespace pipewright::hil
