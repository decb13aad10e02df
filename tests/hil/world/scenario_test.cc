// SPDX-License-Identifier: MIT
#include "hil/world/scenario.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace pipewright::hil {
namespace {

const std::string kGood =
    "name = 'test'\n"
    "[workspace]\n"
    "min_m = [0.1, 0.1, 0.1]\n"
    "max_m = [1.4, 1.4, 1.4]\n"
    "[start]\n"
    "x_m = 0.3\n"
    "y_m = 0.75\n"
    "yaw_rad = 0\n";

ScenarioResult Parse(const std::string& text) { return ParseScenario(text, "t.toml", ""); }

TEST(Scenario, WithTheLeastSaidHasTheDocumentedDefaults) {
  const ScenarioResult result = Parse(kGood);
  ASSERT_TRUE(result.scenario) << result.errors[0];
  const Scenario& s = *result.scenario;
  EXPECT_TRUE(s.map.min_m.isApprox(Vector3d(-0.4, -0.4, -0.1)));
  EXPECT_TRUE(s.map.max_m.isApprox(Vector3d(1.9, 1.9, 1.9)));
  EXPECT_TRUE(s.start.joints_rad.empty());
  EXPECT_EQ(s.start.clearance_m, 0.15);
  EXPECT_EQ(s.camera.width, 212);
  EXPECT_TRUE(s.solids.empty());
}

TEST(Scenario, KeepsWhatEachTableSays) {
  const ScenarioResult result = Parse(
      kGood +
      "joints_rad = [1, 2, 3, 4, 5, 6, 7]\n"
      "[[cylinder]]\nname='c'\nfrom_m=[1,0,0]\nto_m=[1,2,0]\nradius_m=0.05\n"
      "[[plane]]\nname='p'\nnormal=[0,-2,0]\noffset_m=-3\nground=true\n"
      "[[box]]\nname='b'\ncenter_m=[1,2,3]\nsize_m=[1,2,3]\nrpy_rad=[0,0,1.5707963267948966]\n"
      "[camera]\nrate_hz=30\n"
      "[base]\nyaw_scale_slow=1.06\nyaw_scale_fast=1.03\nslip=0.01\nslip_sigma=0.02\n"
      "[[fault]]\ndevice='arm3'\nkind='silent'\nat_s=2.5\n"
      "[[fault]]\ndevice='tracer'\nkind='slip'\nat_s=3\nfor_s=2\nright=0.3\n");
  ASSERT_TRUE(result.scenario) << result.errors[0];
  const Scenario& s = *result.scenario;
  ASSERT_EQ(s.solids.size(), 3U);
  // Points on and off each surface tell its place.
  EXPECT_NEAR(Distance(s.solids[0], Vector3d(0, 2.5, 0)), 0.5, 1e-12);  // normal'p = -2.5 > -3
  EXPECT_TRUE(s.solids[0].ground);
  EXPECT_NEAR(Distance(s.solids[1], Vector3d(3, 2, 3)), 1, 1e-12);  // turned: 2 long in x
  EXPECT_NEAR(Distance(s.solids[2], Vector3d(1, 1, 0.25)), 0.2, 1e-12);
  EXPECT_NEAR(Distance(s.solids[2], Vector3d(1, 2.5, 0)), 0.5, 1e-12);
  EXPECT_EQ(s.start.joints_rad[6], 7);
  EXPECT_EQ(s.camera.rate_hz, 30);
  EXPECT_EQ(s.base.yaw_scale_slow, 1.06);
  EXPECT_EQ(s.base.yaw_scale_fast, 1.03);
  EXPECT_EQ(s.base.slip, 0.01);
  EXPECT_EQ(s.base.slip_sigma, 0.02);
  ASSERT_EQ(s.faults.size(), 2U);
  EXPECT_EQ(s.faults[0].device, "arm3");
  EXPECT_EQ(s.faults[0].kind, FaultKind::kSilent);
  EXPECT_EQ(s.faults[0].at_s, 2.5);
  EXPECT_EQ(s.faults[1].kind, FaultKind::kSlip);
  EXPECT_EQ(s.faults[1].for_s, 2);
  EXPECT_EQ(s.faults[1].left, 0);
  EXPECT_EQ(s.faults[1].right, 0.3);
}

TEST(Scenario, DefaultMapHoldsAStartThatIsFarFromTheWorkspace) {
  const std::string head =
      "name = 't'\n[workspace]\nmin_m = [2, 0, 0.1]\nmax_m = [3, 1, 1]\n[start]\n"
      "y_m = 0.5\nyaw_rad = 0\n";
  const ScenarioResult near = Parse(head + "x_m = -1\n");
  ASSERT_TRUE(near.scenario) << near.errors[0];
  EXPECT_TRUE(near.scenario->map.min_m.isApprox(Vector3d(-1.6, -0.5, -0.1)));
  EXPECT_TRUE(near.scenario->map.max_m.isApprox(Vector3d(3.5, 1.5, 1.5)));
  const ScenarioResult far = Parse(head + "x_m = -8\n");
  ASSERT_EQ(far.errors.size(), 1U);
  EXPECT_NE(far.errors[0].find("t.toml:5:1: start: too far"), std::string::npos) << far.errors[0];
}

struct Bad {
  const char* name;
  const char* added;
  const char* expected;  ///< part of the one error
};

const Bad kBad[] = {
    {"an unknown key", "speed = 1\n", "t.toml:9:1: start.speed: unknown key"},
    {"an unknown table", "[wind]\nx = 1\n", "t.toml:9:2: wind: unknown key"},
    {"a missing key", "[[plane]]\nname='p'\nnormal=[0,0,1]\n",
     "t.toml:9:1: plane[0].offset_m: missing"},
    {"a wrong type", "[[box]]\nname=3\ncenter_m=[0,0,0]\nsize_m=[1,1,1]\n",
     "t.toml:10:6: box[0].name: must be text"},
    {"a number that is text", "clearance_m = '1'\n", "start.clearance_m: must be a number"},
    {"a number out of range", "clearance_m = -1\n",
     "t.toml:9:15: start.clearance_m: must be within"},
    {"not a number", "clearance_m = nan\n", "start.clearance_m: must be within"},
    {"infinity", "[[box]]\nname='b'\ncenter_m=[0,inf,0]\nsize_m=[1,1,1]\n",
     "t.toml:11:13: box[0].center_m: must be within"},
    {"too few joints", "joints_rad = [1, 2]\n", "start.joints_rad: must be an array of 7 numbers"},
    {"a flat box", "[[box]]\nname='b'\ncenter_m=[0,0,0]\nsize_m=[1,0,1]\n",
     "box[0].size_m: must be"},
    {"a pipe without length",
     "[[cylinder]]\nname='c'\nfrom_m=[1,1,1]\nto_m=[1,1,1]\nradius_m=0.1\n",
     "t.toml:12:6: cylinder[0].to_m: must differ from from_m"},
    {"a normal of zero", "[[plane]]\nname='p'\nnormal=[0,0,0]\noffset_m=0\n",
     "plane[0].normal: must not be zero"},
    {"a name given twice",
     "[[plane]]\nname='p'\nnormal=[0,0,1]\noffset_m=0\n[[box]]\nname='p'\ncenter_m=[0,0,0]\n"
     "size_m=[1,1,1]\n",
     "t.toml:14:6: box[0].name: is taken"},
    {"a mesh without its file", "[[mesh]]\nname='m'\nfile='none.stl'\n",
     "t.toml:11:6: mesh[0].file: cannot be read"},
    {"a boolean that is a number", "[[plane]]\nname='p'\nnormal=[0,0,1]\noffset_m=0\nground=1\n",
     "plane[0].ground: must be true or false"},
    {"a table that is an array", "[[camera]]\nwidth=64\n", "camera: must be a table"},
    {"an array of tables that is a table", "[plane]\nname='p'\n", "must be an array of tables"},
    {"a camera with half a pixel", "[camera]\nwidth=100.5\n", "camera.width: must be an integer"},
    {"a camera without depth", "[camera]\nz_min_m=1\nz_max_m=0.5\n",
     "camera.z_max_m: must be greater"},
    {"an unknown device", "[[fault]]\ndevice='arm8'\nkind='silent'\n", "fault[0].device: must be"},
    {"an unknown fault", "[[fault]]\ndevice='arm7'\nkind='tired'\n", "fault[0].kind: must be"},
    {"a slip of an arm", "[[fault]]\ndevice='arm7'\nkind='slip'\nfor_s=1\n",
     "t.toml:11:6: fault[0].kind: only the tracer"},
    {"a slip without end", "[[fault]]\ndevice='tracer'\nkind='slip'\n", "fault[0].for_s: missing"},
    {"a slip of more than all", "[[fault]]\ndevice='tracer'\nkind='slip'\nfor_s=1\nleft=1.5\n",
     "t.toml:13:6: fault[0].left: must be within"},
    {"a silence with an end", "[[fault]]\ndevice='arm7'\nkind='silent'\nfor_s=1\n",
     "fault[0].for_s: unknown key"},
    {"a base that turns backwards", "[base]\nyaw_scale_slow=-1\n",
     "t.toml:10:16: base.yaw_scale_slow: must be within"},
    {"an absence with a time", "[[fault]]\ndevice='arm7'\nkind='absent'\nat_s=3\n",
     "fault[0].at_s: an absent device"},
    {"a map smaller than the workspace", "[map]\nlo_m=[0,0,0]\nhi_m=[1,1,1]\n",
     "the map must hold the whole workspace"},
    {"a map without the start", "[map]\nlo_m=[0.1,0.9,0]\nhi_m=[2,2,2]\n",
     "t.toml:10:6: map.lo_m: the map must hold"},
    {"a map inside out", "[map]\nlo_m=[0,0,0]\nhi_m=[2,-2,2]\n",
     "map.hi_m: must be greater than lo_m"},
    {"broken syntax", "x = = 1\n", "t.toml:9:"},
};

TEST(Scenario, NamesThePlaceAndTheKeyOfWhatIsWrong) {
  for (const Bad& bad : kBad) {
    SCOPED_TRACE(bad.name);
    const ScenarioResult result = Parse(kGood + bad.added);
    EXPECT_FALSE(result.scenario);
    ASSERT_FALSE(result.errors.empty());
    EXPECT_NE(result.errors[0].find(bad.expected), std::string::npos) << result.errors[0];
  }
}

TEST(Scenario, ReportsEverythingThatIsMissing) {
  const ScenarioResult result = Parse("");
  EXPECT_FALSE(result.scenario);
  EXPECT_EQ(result.errors.size(), 3U);  // name, workspace, start
}

TEST(LoadScenario, SaysWhenThereIsNoSuchThing) {
  const ScenarioResult result = LoadScenario("/nowhere/cell.toml");
  ASSERT_EQ(result.errors.size(), 1U);
  EXPECT_NE(result.errors[0].find("/nowhere/cell.toml"), std::string::npos);
  EXPECT_FALSE(LoadScenario("/").scenario);  // a folder
}

TEST(LoadScenario, FindsMeshesBesideTheFile) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "pipewright_cell";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "part.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  std::ofstream(folder / "cell.toml") << kGood +
                                             "[[mesh]]\nname='m'\nfile='part.obj'\nscale=0.5\n"
                                             "position_m=[0,0,1]\n";
  const ScenarioResult result = LoadScenario((folder / "cell.toml").string());
  ASSERT_TRUE(result.scenario) << result.errors[0];
  EXPECT_NEAR(Distance(result.scenario->solids[0], Vector3d(0.1, 0.1, 1.5)), 0.5, 1e-8);
  std::filesystem::remove_all(folder);
}

TEST(ShippedScenarios, AreThereAndValid) {
  ASSERT_EQ(ShippedScenarios().size(), 3U);
  int pipes = 0;
  for (const ShippedToml& shipped : ShippedScenarios()) {
    const ScenarioResult result = LoadScenario(std::string(shipped.name));
    ASSERT_TRUE(result.scenario) << result.errors[0];
    EXPECT_EQ(result.scenario->name, shipped.name);
    int count = 0;
    for (const Solid& solid : result.scenario->solids) {
      count += IsPipe(solid);
    }
    EXPECT_EQ(count, ++pipes);
  }
}

TEST(VoxelsOf, CountsBoundsOnTheGridOnceAndTornVoxelsWhole) {
  const VoxelRange cell = VoxelsOf({{0.1, 0.15, -0.4}, {1.4, 1.35, -0.1}});
  EXPECT_EQ(cell.lo, (std::array{2, 3, -8}));
  EXPECT_EQ(cell.hi, (std::array{27, 26, -3}));
  const VoxelRange torn = VoxelsOf({{0.12, 0, 0}, {0.16, 1, 1}});
  EXPECT_EQ(torn.lo[0], 2);
  EXPECT_EQ(torn.hi[0], 3);
}

}  // namespace
}  // namespace pipewright::hil
