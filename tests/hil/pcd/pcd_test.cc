// SPDX-License-Identifier: MIT
#include "hil/pcd/pcd.h"

#include <gtest/gtest.h>

#include <cmath>

#include "platform/core/rng.h"
#include "tests/support/command.h"
#include "tests/support/pcd_file.h"

namespace pipewright::hil {
namespace {

using test::BinaryPcd;
using test::Bytes;
using test::CompressedPcd;
using test::PcdHeaderText;

const std::vector<Eigen::Vector3f> kPoints = {{1, 2, 3}, {-0.5F, 1e-3F, 4e3F}, {0, -7, 0.25F}};

PcdResult Read(const std::string& bytes) {
  static const std::filesystem::path folder = test::TestFolder();
  test::WriteFile(folder / "cloud.pcd", bytes);
  return ReadPcd(folder / "cloud.pcd");
}

void ExpectPoints(const PcdResult& result, const std::vector<Eigen::Vector3f>& points) {
  ASSERT_TRUE(result.cloud) << result.error;
  EXPECT_EQ(result.error, "");
  EXPECT_EQ(result.cloud->points, points);
}

TEST(ReadPcd, GivesTheSamePointsFromAllThreeKindsOfData) {
  ExpectPoints(Read(BinaryPcd(kPoints)), kPoints);
  ExpectPoints(Read(CompressedPcd(kPoints)), kPoints);
  ExpectPoints(Read(PcdHeaderText(3, 1, "ascii") + "1 2 3\n-0.5 1e-3 4000\r\n0\t-7  0.25"),
               kPoints);
}

TEST(ReadPcd, TakesXyzFromAmongOtherFieldsOfOtherSizes) {
  const std::string head =
      "VERSION .7\nFIELDS rgb z normal y x\nSIZE 4 8 4 4 4\nTYPE U F F F F\nCOUNT 1 1 3 1 1\n"
      "WIDTH 1\nHEIGHT 2\nDATA ";
  const std::vector<Eigen::Vector3f> points = {{5, 4, 3}, {50, 40, 30}};
  ExpectPoints(Read(head + "ascii\n1 3 9 9 9 4 5\n1 30 9 nan 9 40 50\n"), points);
  std::string body;
  for (const Eigen::Vector3f& p : points) {
    const std::uint32_t rgb = 77;
    const double z = p.z();
    const float rest[5] = {9, 9, 9, p.y(), p.x()};
    body += Bytes(&rgb, 4) + Bytes(&z, 8) + Bytes(rest, sizeof rest);
  }
  const PcdResult result = Read(head + "binary\n" + body);
  ExpectPoints(result, points);
  EXPECT_EQ(result.cloud->width, 1);
  EXPECT_EQ(result.cloud->height, 2);
}

TEST(ReadPcd, KeepsPointsWithoutReadingAsNan) {
  const PcdResult result = Read(PcdHeaderText(2, 1, "ascii") + "nan nan nan\n1 2 3\n");
  ASSERT_TRUE(result.cloud) << result.error;
  EXPECT_TRUE(std::isnan(result.cloud->points[0].x()));
  EXPECT_EQ(result.cloud->points[1].z(), 3);
}

TEST(ReadPcd, SaysWhatIsWrongAndWhere) {
  const std::string head = PcdHeaderText(3, 1, "ascii");
  const std::string binary = BinaryPcd(kPoints);
  const std::string compressed = CompressedPcd(kPoints);
  const auto with = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  const struct {
    const char* what;
    std::string bytes;
    const char* expected;
  } cases[] = {
      {"empty", "", "cloud.pcd: cannot be read, or is empty"},
      {"no header", "1 2 3\n", "line 1: '1' is no key"},
      {"no DATA", head.substr(0, 60), "the header ends without DATA"},
      {"no FIELDS", with(head, "FIELDS x y z\n", ""), "SIZE has 3 values for 0 fields"},
      {"no field z", with(head, "x y z", "x y q"), "line 11: there is no field z"},
      {"a field twice", with(head, "x y z", "x y y"), "line 3: field y stands twice"},
      {"x an int", with(head, "F F F", "I F F"), "field x is not one float"},
      {"a size of 3", with(head, "4 4 4", "4 3 4"), "line 4: field y: SIZE '3'"},
      {"a type Q", with(head, "F F F", "F F Q"), "line 5: field z: TYPE 'Q'"},
      {"a count of 0", with(head, "1 1 1", "1 0 1"), "line 6: field y: COUNT '0'"},
      {"a width of words", with(head, "WIDTH 3", "WIDTH three"), "line 7: WIDTH is not one whole"},
      {"width missing", with(head, "WIDTH 3\n", ""), "WIDTH is missing before DATA"},
      {"too many points", with(head, "WIDTH 3", "WIDTH 268435456") + "1 2 3\n", "is not POINTS"},
      {"points that do not fit", with(head, "POINTS 3", "POINTS 4"), "WIDTH 3 times HEIGHT 1"},
      {"unknown data", with(head, "ascii", "zip"), "line 11: DATA is none of"},
      {"a word for a number", head + "1 2 3\n4 five 6\n", "line 13: field y: 'five' is no number"},
      {"too few values", head + "1 2\n", "line 12: field z is missing"},
      {"too many values", head + "1 2 3 4\n", "line 12: has more values than fields"},
      {"too few lines", head + "1 2 3\n", "line 13: the file ends after 1 of 3 points"},
      {"binary cut short", binary.substr(0, binary.size() - 1), "is cut short at byte"},
      {"packed cut short", compressed.substr(0, compressed.size() - 1), "is cut short at byte"},
      {"no packed size", compressed.substr(0, compressed.find("compressed\n") + 15),
       "the packed size"},
      {"packed size of others",
       with(compressed, std::string("\x24\0\0\0", 4), std::string("\x25\0\0\0", 4)),
       "cannot be the 36 of 3 points"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    const PcdResult result = Read(c.bytes);
    EXPECT_FALSE(result.cloud);
    EXPECT_NE(result.error.find(c.expected), std::string::npos) << result.error;
  }
  EXPECT_NE(ReadPcd("none.pcd").error.find("none.pcd: no such file"), std::string::npos);
  EXPECT_NE(ReadPcd("/").error.find("is not a file"), std::string::npos);
}

TEST(ReadPcd, TakesNoMemoryForPointsThatAFileOnlyClaims) {
  for (const char* data : {"ascii", "binary", "binary_compressed"}) {
    SCOPED_TRACE(data);
    const std::string body(8, '\xff');
    EXPECT_FALSE(Read(PcdHeaderText(1 << 14, 1 << 13, data) + body).cloud);
  }
}

TEST(ReadPcd, EndsProperlyWhateverByteIsWrongOrMissing) {
  Rng rng(5);
  for (const std::string& good :
       {BinaryPcd(kPoints), CompressedPcd(kPoints),
        PcdHeaderText(3, 1, "ascii") + "1 2 3\n-0.5 1e-3 4000\n0 -7 0.25\n"}) {
    for (std::size_t at = 0; at < good.size(); ++at) {
      SCOPED_TRACE(at);
      std::string flipped = good;
      flipped[at] = static_cast<char>(flipped[at] ^ (1 << rng.Index(8)));
      for (const std::string& bytes : {flipped, good.substr(0, at)}) {
        const PcdResult result = Read(bytes);
        EXPECT_EQ(result.cloud.has_value(), result.error.empty());
        if (result.cloud) {
          EXPECT_EQ(result.cloud->points.size(),
                    static_cast<std::size_t>(result.cloud->width) * result.cloud->height);
        }
      }
    }
  }
}

}  // namespace
}  // namespace pipewright::hil
