// SPDX-License-Identifier: MIT
// Missions that cannot go well: each ends by itself, says why, and leaves all it saw.
#include "mission.h"

namespace pipewright {
namespace {

using test::MissionRun;

std::string Fault(const std::string& device, const std::string& kind, const std::string& at_s) {
  return "\n[[fault]]\ndevice = \"" + device + "\"\nkind = \"" + kind + "\"\nat_s = " + at_s + "\n";
}

struct FaultCase {
  const char* name;
  std::string faults;
  std::string detail;  ///< in stop_detail
  double at_s;         ///< when the device fails
  double within_s;     ///< from then on the run must be over
};

void PrintTo(const FaultCase& c, std::ostream* out) { *out << c.name; }

class FaultyMission : public testing::TestWithParam<FaultCase> {};

TEST_P(FaultyMission, EndsWithinItsBoundAndNamesTheDevice) {
  const FaultCase& c = GetParam();
  const MissionRun mission =
      test::RunMission(test::TestFolder(), "run", test::ShippedText("pipes1") + c.faults,
                       "--seed 2 --time-limit 60");
  ASSERT_TRUE(mission.run.is_object()) << mission.error;
  EXPECT_EQ(mission.exit_code, 1);
  EXPECT_EQ(mission.run["stop_reason"], "device_fault");
  EXPECT_NE(mission.run["stop_detail"].get<std::string>().find(c.detail), std::string::npos)
      << mission.run["stop_detail"];
  EXPECT_GT(mission.run["sim_time_s"], c.at_s);
  EXPECT_LT(mission.run["sim_time_s"], c.at_s + c.within_s);
  EXPECT_EQ(mission.run["contacts"], 0);
  test::ExpectWholeFolder(mission);
}

// The start-up timeout of the drivers is 5 s, that of a state's age 0.1 to 1 s; then the robot has
// 5 s to come to rest and to be disabled.
INSTANTIATE_TEST_SUITE_P(
    All, FaultyMission,
    testing::Values(FaultCase{"SilentJoint", Fault("arm3", "silent", "6.0"), "arm joint 3", 6, 7},
                    FaultCase{"SilentBase", Fault("tracer", "silent", "5.0"), "base", 5, 7},
                    FaultCase{"SilentCamera", Fault("camera", "silent", "5.0"), "camera", 5, 7},
                    FaultCase{"AbsentJoint", Fault("arm7", "absent", "0.0"), "arm joint 7", 0, 12},
                    FaultCase{"EmptyBus",
                              Fault("tracer", "absent", "0.0") + Fault("arm1", "absent", "0.0") +
                                  Fault("arm2", "absent", "0.0") + Fault("arm3", "absent", "0.0") +
                                  Fault("arm4", "absent", "0.0") + Fault("arm5", "absent", "0.0") +
                                  Fault("arm6", "absent", "0.0") + Fault("arm7", "absent", "0.0"),
                              "base: not heard on the bus", 0, 12}),
    [](const auto& test) { return std::string(test.param.name); });

/// A robot walled in where it stands: nothing of W can be reached or seen.
constexpr const char* kBoxedIn = R"(
name = "boxed_in"
[workspace]
min_m = [1.6, 0.1, 0.1]
max_m = [2.2, 0.7, 0.7]
[start]
x_m = 0.0
y_m = 0.0
yaw_rad = 0.0
clearance_m = 0.10
[[plane]]
name = "floor"
normal = [0, 0, 1]
offset_m = 0.0
ground = true
[[box]]
name = "ahead"
center_m = [0.85, 0.0, 0.75]
size_m = [0.1, 2.0, 1.5]
[[box]]
name = "behind"
center_m = [-0.75, 0.0, 0.75]
size_m = [0.1, 2.0, 1.5]
[[box]]
name = "left"
center_m = [0.0, 0.75, 0.75]
size_m = [1.6, 0.1, 1.5]
[[box]]
name = "right"
center_m = [0.0, -0.75, 0.75]
size_m = [1.6, 0.1, 1.5]
[[box]]
name = "lid"
center_m = [0.0, 0.0, 1.6]
size_m = [1.8, 1.8, 0.1]
[[cylinder]]
name = "pipe"
from_m = [1.9, 0.4, 0.0]
to_m = [1.9, 0.4, 1.5]
radius_m = 0.06
)";

TEST(UnreachableCell, EndsAndSaysSo) {
  const MissionRun mission =
      test::RunMission(test::TestFolder(), "run", kBoxedIn, "--time-limit 120");
  ASSERT_TRUE(mission.run.is_object()) << mission.error;
  const std::string reason = mission.run["stop_reason"];
  EXPECT_TRUE(reason == "no_reachable_view" || reason == "complete") << reason;
  EXPECT_LT(mission.run["sim_time_s"], 110);
  EXPECT_EQ(mission.exit_code, reason == "complete" ? 0 : 1);
  EXPECT_EQ(mission.run["contacts"], 0) << mission.run["touched"];
  test::ExpectWholeFolder(mission);
}

}  // namespace
}  // namespace pipewright
