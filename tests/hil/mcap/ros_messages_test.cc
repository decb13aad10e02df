// SPDX-License-Identifier: MIT
#include "hil/mcap/ros_messages.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

namespace pipewright::hil {
namespace {

std::int32_t SecondsOf(std::int64_t stamp_ns) {
  CdrWriter cdr;
  WriteRos(cdr, RosTwist{.header = {stamp_ns, "base_link"}});
  std::int32_t seconds = 0;
  std::memcpy(&seconds, cdr.bytes().data() + 4, sizeof seconds);
  return seconds;
}

TEST(RosMessages, HaveNoSecondsBeyondThoseOfRos) {
  EXPECT_EQ(SecondsOf(1'700'000'000'999'999'999), 1'700'000'000);
  EXPECT_EQ(SecondsOf(9'000'000'000'000'000'000), std::numeric_limits<std::int32_t>::max());
}

TEST(RosMessages, HaveDefinitionsOfAllThatTheyAreMadeOf) {
  for (const RosType* type :
       {&kRosJointState, &kRosOdometry, &kRosTransforms, &kRosTwistStamped, &kRosDiagnostics}) {
    SCOPED_TRACE(type->name);
    EXPECT_NE(type->name.find("/msg/"), std::string_view::npos);
    const std::string definition = type->Definition();
    EXPECT_NE(definition.find("MSG: std_msgs/Header\n"), std::string::npos);
    EXPECT_NE(definition.find("MSG: builtin_interfaces/Time\n"), std::string::npos);
  }
}

}  // namespace
}  // namespace pipewright::hil
