// SPDX-License-Identifier: MIT
#include "tests/timing/replay/frame_difference.h"

#include <gtest/gtest.h>

namespace pipewright::timing {
namespace {

struct Case {
  const char* name;
  BusName bus;
  can::Frame a;
  can::Frame b;
  std::optional<std::int64_t> lsb;
};

// Bytes by hand: 0x111 is two 16-bit numbers, high byte first; 0x201 a controlword and a 32-bit
// velocity, low byte first.
constexpr Case kCases[] = {
    {"the same", BusName::kBase, {.id = 0x111, .dlc = 8}, {.id = 0x111, .dlc = 8}, 0},
    {"a twist's two numbers: the larger",
     BusName::kBase,
     {.id = 0x111, .dlc = 8, .data = {0x00, 0x96, 0x00, 0x02}},
     {.id = 0x111, .dlc = 8, .data = {0x00, 0x97, 0xFF, 0xFD}},  // 150 to 151, 2 to -3
     5},
    {"across a byte",
     BusName::kBase,
     {.id = 0x111, .dlc = 8, .data = {0x01, 0x00}},
     {.id = 0x111, .dlc = 8, .data = {0x00, 0xFF}},
     1},
    {"a joint's velocity across zero",
     BusName::kArm,
     {.id = 0x203, .dlc = 6, .data = {0x0F, 0, 0xFF, 0xFF, 0xFF, 0xFF}},
     {.id = 0x203, .dlc = 6, .data = {0x0F, 0, 0x01, 0x00, 0x00, 0x00}},
     2},
    {"another controlword is no quantity",
     BusName::kArm,
     {.id = 0x203, .dlc = 6, .data = {0x0F}},
     {.id = 0x203, .dlc = 6, .data = {0x06}},
     std::nullopt},
    {"a byte that no signal claims",
     BusName::kBase,
     {.id = 0x111, .dlc = 8},
     {.id = 0x111, .dlc = 8, .data = {0, 0, 0, 0, 0, 1}},
     std::nullopt},
    {"another joint",
     BusName::kArm,
     {.id = 0x203, .dlc = 6},
     {.id = 0x204, .dlc = 6},
     std::nullopt},
    {"another length",
     BusName::kArm,
     {.id = 0x203, .dlc = 6},
     {.id = 0x203, .dlc = 5},
     std::nullopt},
    {"an id that is in no table",
     BusName::kArm,
     {.id = 0x111, .dlc = 8},
     {.id = 0x111, .dlc = 8, .data = {0, 1}},
     std::nullopt},
    {"a velocity that no drive takes",
     BusName::kArm,
     {.id = 0x203, .dlc = 6},
     {.id = 0x203, .dlc = 6, .data = {0, 0, 0, 0, 0, 0x7F}},
     std::nullopt},
};

TEST(LsbDifference, CountsOnlyQuantities) {
  for (const Case& c : kCases) {
    SCOPED_TRACE(c.name);
    EXPECT_EQ(LsbDifference(c.bus, c.a, c.b), c.lsb);
    EXPECT_EQ(LsbDifference(c.bus, c.b, c.a), c.lsb);
  }
}

}  // namespace
}  // namespace pipewright::timing
