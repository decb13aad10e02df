// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <map>

#include "hil/cli/heap_watch.h"
#include "perception/map/distance_field.h"
#include "tests/support/command_json.h"

namespace pipewright::hil {
namespace {

using nlohmann::json;
using test::CommandResult;
using test::TestFolder;

CommandResult Memory(const std::string& arguments) {
  return test::RunCommand(PIPEWRIGHT_BINARY, "memory " + arguments, TestFolder());
}

TEST(MemoryCommand, PrintsEveryPartAndTheirSum) {
  const json figures = test::Parsed(Memory("--scenario pipes1 --json"));
  ASSERT_TRUE(figures.is_object());
  EXPECT_EQ(figures["scenario"], "pipes1");
  std::int64_t sum = 0;
  std::map<std::string, std::int64_t> heap;
  for (const json& part : figures["parts"]) {
    EXPECT_GT(part["in_place_bytes"], 0) << part;
    heap[part["part"]] = part["heap_bytes"].get<std::int64_t>();
    sum += part["in_place_bytes"].get<std::int64_t>() + part["heap_bytes"].get<std::int64_t>();
  }
  EXPECT_EQ(figures["total_bytes"], sum);
  EXPECT_EQ(heap.at("control task"), 0) << "the control path has no heap";
  EXPECT_GT(heap.at("its map"), 0);
  EXPECT_EQ(heap.at("mapping to planning"),
            3 * (heap.at("its map") + heap.at("its distance field")));
  EXPECT_EQ(heap.at("planning task") > 0, HeapWatch::Counting());
}

TEST(MemoryCommand, PrintsATableAndTeachesByHelp) {
  const CommandResult table = Memory("--scenario pipes3");
  EXPECT_EQ(table.exit_code, 0) << table.error;
  for (const char* expected : {"control task", "its map", "planning task", "total"}) {
    EXPECT_NE(table.out.find(expected), std::string::npos) << table.out;
  }
  EXPECT_NE(Memory("--help").out.find("Example: pipewright memory"), std::string::npos);
}

TEST(MemoryCommand, RefusesAScenarioThatIsNone) {
  const CommandResult result = Memory("--scenario none");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_NE(result.error.find("none"), std::string::npos);
}

}  // namespace
}  // namespace pipewright::hil
