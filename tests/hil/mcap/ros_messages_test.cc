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
  for (const RosType* type : {&kRosJointState, &kRosOdometry, &kRosTransforms, &kRosTwistStamped,
                              &kRosDiagnostics, &kRosPointCloud}) {
    SCOPED_TRACE(type->name);
    EXPECT_NE(type->name.find("/msg/"), std::string_view::npos);
    const std::string definition = type->Definition();
    EXPECT_NE(definition.find("MSG: std_msgs/Header\n"), std::string::npos);
    EXPECT_NE(definition.find("MSG: builtin_interfaces/Time\n"), std::string::npos);
  }
}

// By sensor_msgs/msg/PointCloud2.msg and PointField.msg, byte by byte.
TEST(RosMessages, LayACloudOutAsPointCloud2) {
  using namespace std::string_literals;
  const float points[] = {1, -2, 0.5F, 0, 0, std::numeric_limits<float>::quiet_NaN()};
  CdrWriter cdr;
  WriteRos(cdr, RosPointCloud{{2'000'000'003, "cam"}, 2, 1, points});
  EXPECT_EQ(cdr.bytes().substr(4),
            "\x02\x00\x00\x00\x03\x00\x00\x00"
            "\x04\x00\x00\x00"
            "cam\x00"
            "\x01\x00\x00\x00\x02\x00\x00\x00"  // height, width
            "\x03\x00\x00\x00"
            "\x02\x00\x00\x00x\x00\x00\x00"
            "\x00\x00\x00\x00\x07\x00\x00\x00\x01\x00\x00\x00"  // offset, FLOAT32, count
            "\x02\x00\x00\x00y\x00\x00\x00"
            "\x04\x00\x00\x00\x07\x00\x00\x00\x01\x00\x00\x00"
            "\x02\x00\x00\x00z\x00\x00\x00"
            "\x08\x00\x00\x00\x07\x00\x00\x00\x01\x00\x00\x00"
            "\x00\x00\x00\x00\x0C\x00\x00\x00\x18\x00\x00\x00"  // little-endian; steps
            "\x18\x00\x00\x00"
            "\x00\x00\x80\x3F\x00\x00\x00\xC0\x00\x00\x00\x3F"
            "\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\xC0\x7F"
            "\x00"s);  // not dense
}

}  // namespace
}  // namespace pipewright::hil
