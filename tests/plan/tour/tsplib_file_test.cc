// SPDX-License-Identifier: MIT
#include "tests/plan/tour/tsplib_file.h"

#include <gtest/gtest.h>

#include <sstream>
#include <vector>

namespace pipewright::test {
namespace {

TsplibResult Read(const std::string& text) {
  std::istringstream in(text);
  return ReadTsplib(in, "f");
}

constexpr char kMatrix[] =
    "NAME:  three\nTYPE: ATSP\nCOMMENT: a: b\nDIMENSION:  3\nEDGE_WEIGHT_TYPE: EXPLICIT\n"
    "EDGE_WEIGHT_FORMAT: FULL_MATRIX \nEDGE_WEIGHT_SECTION\n";

TEST(TsplibFile, ReadsAMatrixHoweverItsLinesAreBroken) {
  const TsplibResult r = Read(std::string(kMatrix) + " 9999 1 2\n3 9999\n\n4 5 6 9999\nEOF\n");
  ASSERT_TRUE(r.instance) << r.error;
  EXPECT_EQ(r.instance->name, "three");
  EXPECT_EQ(r.instance->n, 3);
  EXPECT_EQ(r.instance->costs, (std::vector<float>{9999, 1, 2, 3, 9999, 4, 5, 6, 9999}));
}

TEST(TsplibFile, RoundsDistances) {
  const TsplibResult r = Read(
      "NAME : p\r\nTYPE : TSP\r\nDIMENSION : 3\r\nEDGE_WEIGHT_TYPE : EUC_2D\r\n"
      "NODE_COORD_SECTION\r\n1 0 0\r\n2 1.5 0\r\n3 1.2e0 -0.5\r\nEOF\r\n");
  ASSERT_TRUE(r.instance) << r.error;
  EXPECT_EQ(r.instance->costs, (std::vector<float>{0, 2, 1, 2, 0, 1, 1, 1, 0}));
}

TEST(TsplibFile, NamesTheLineOfWhatIsWrong) {
  const std::string matrix = kMatrix;
  const struct {
    const char* name;
    std::string text;
    std::string error;
  } rows[] = {
      {"empty", "", "f:0: the file ends before a section of weights or coordinates"},
      {"short", matrix + "1 2 3\n4 5 6\n", "f:9: the file ends within its section"},
      {"no number", matrix + "1 2 3\n4 5x 6\n", "f:9: '5x' is not a number"},
      {"not finite", matrix + "1 2 3\n4 nan 6\n", "f:9: 'nan' is not a number"},
      {"unknown", "NAME: a\nrubbish\n", "f:2: 'rubbish' is not known"},
      {"no size", "EDGE_WEIGHT_SECTION\n1\n", "f:1: no DIMENSION before this section"},
      {"one node", "DIMENSION: 1\n", "f:1: DIMENSION is not from 2 to 4096"},
      {"huge", "DIMENSION: 99999\n", "f:1: DIMENSION is not from 2 to 4096"},
      {"of another type", "TYPE: CVRP\nDIMENSION: 3\nNODE_COORD_SECTION\n",
       "f:3: TYPE CVRP is not TSP or ATSP"},
      {"other distances", "DIMENSION: 3\nEDGE_WEIGHT_TYPE: GEO\nNODE_COORD_SECTION\n",
       "f:3: EDGE_WEIGHT_TYPE is 'GEO': this section needs EUC_2D"},
      {"half a matrix",
       "DIMENSION: 3\nEDGE_WEIGHT_TYPE: EXPLICIT\nEDGE_WEIGHT_FORMAT: UPPER_ROW\n"
       "EDGE_WEIGHT_SECTION\n",
       "f:4: EDGE_WEIGHT_FORMAT is 'UPPER_ROW', not FULL_MATRIX"},
      {"a node missing",
       "DIMENSION: 3\nEDGE_WEIGHT_TYPE: EUC_2D\nNODE_COORD_SECTION\n1 0 0\n3 1 1\n",
       "f:5: node 2 should be here"},
  };
  for (const auto& row : rows) {
    const TsplibResult r = Read(row.text);
    EXPECT_FALSE(r.instance) << row.name;
    EXPECT_EQ(r.error, row.error) << row.name;
  }
  EXPECT_EQ(ReadTsplibFile("/nowhere/x.atsp").error, "/nowhere/x.atsp: cannot be read");
}

}  // namespace
}  // namespace pipewright::test
