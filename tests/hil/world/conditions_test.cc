// SPDX-License-Identifier: MIT
#include "hil/world/conditions.h"

#include <gtest/gtest.h>

#include "hil/world/scenario.h"

namespace pipewright::hil {
namespace {

using Errors = std::vector<std::string>;

/// A camera that is not a default one, a base that slips, and a camera that falls silent.
Conditions Given() {
  Conditions given;
  given.camera.rate_hz = 30;
  given.camera.lost_fraction = 0.2;
  given.base.slip = 0.05;
  given.faults.push_back({.device = "camera", .kind = FaultKind::kSilent, .at_s = 5});
  return given;
}

TEST(LayOver, ReplacesTheKeysThatItGivesAndNoOthers) {
  Conditions conditions = Given();
  EXPECT_EQ(LayOver("[camera]\nlost_fraction=0.1\ninvalid_fraction=0.3\n[base]\nslip_sigma=0.02\n",
                    "f.toml", conditions),
            Errors{});
  EXPECT_EQ(conditions.camera.lost_fraction, 0.1);
  EXPECT_EQ(conditions.camera.invalid_fraction, 0.3);
  EXPECT_EQ(conditions.base.slip_sigma, 0.02);
  EXPECT_EQ(conditions.camera.rate_hz, 30);
  EXPECT_EQ(conditions.camera.noise_sigma_at_1m, CameraSpec{}.noise_sigma_at_1m);
  EXPECT_EQ(conditions.base.slip, 0.05);
  EXPECT_EQ(conditions.faults.size(), 1U);
}

TEST(LayOver, AddsItsFaultsToThoseThatAreThere) {
  Conditions conditions = Given();
  EXPECT_EQ(LayOver("[[fault]]\ndevice='arm2'\nkind='absent'\n"
                    "[[fault]]\ndevice='tracer'\nkind='slip'\nat_s=3\nfor_s=2\nleft=0.3\n",
                    "f.toml", conditions),
            Errors{});
  ASSERT_EQ(conditions.faults.size(), 3U);
  EXPECT_EQ(conditions.faults[0].device, "camera");
  EXPECT_EQ(conditions.faults[0].at_s, 5);
  EXPECT_EQ(conditions.faults[1].device, "arm2");
  EXPECT_EQ(conditions.faults[1].kind, FaultKind::kAbsent);
  EXPECT_EQ(conditions.faults[2].device, "tracer");
  EXPECT_EQ(conditions.faults[2].kind, FaultKind::kSlip);
  EXPECT_EQ(conditions.faults[2].left, 0.3);
  EXPECT_EQ(conditions.camera.rate_hz, 30);
}

TEST(LayOver, OfNothingChangesNothing) {
  Conditions conditions = Given();
  EXPECT_EQ(LayOver("# all is well\n", "f.toml", conditions), Errors{});
  EXPECT_EQ(conditions.camera.lost_fraction, 0.2);
  EXPECT_EQ(conditions.faults.size(), 1U);
}

TEST(LayOver, LeavesTheRestOfAScenarioAlone) {
  ScenarioResult result = LoadScenario("pipes2");
  ASSERT_TRUE(result.scenario) << result.errors[0];
  const std::size_t solids = result.scenario->solids.size();
  EXPECT_EQ(LayOver("[base]\nslip=0.1\n", "f.toml", *result.scenario), Errors{});
  EXPECT_EQ(result.scenario->base.slip, 0.1);
  EXPECT_EQ(result.scenario->name, "pipes2");
  EXPECT_EQ(result.scenario->solids.size(), solids);
}

struct Bad {
  const char* name;
  const char* text;
  const char* expected;  ///< start of the one error
};

const Bad kBad[] = {
    {"a world", "[workspace]\nmin_m=[0,0,0]\n", "f.toml:1:2: workspace: unknown key"},
    {"a solid", "[base]\nslip=0.1\n[[box]]\nname='b'\n", "f.toml:3:3: box: unknown key"},
    {"a name", "name='rough'\n", "f.toml:1:1: name: unknown key"},
    {"an unknown key of the camera", "[camera]\nspeed=1\n",
     "f.toml:2:1: camera.speed: unknown key"},
    {"an unknown key of the base", "[base]\n\nyaw_scale=1\n",
     "f.toml:3:1: base.yaw_scale: unknown key"},
    {"an unknown key of a fault", "[[fault]]\ndevice='arm1'\nkind='silent'\nleft=0.5\n",
     "f.toml:4:1: fault[0].left: unknown key"},
    {"a number that is text", "[camera]\nlost_fraction='all'\n",
     "f.toml:2:15: camera.lost_fraction: must be a number"},
    {"a number out of range", "[camera]\nlost_fraction=1\n",
     "f.toml:2:15: camera.lost_fraction: must be within [0, 0.95]"},
    {"not a number", "[base]\nslip=nan\n", "f.toml:2:6: base.slip: must be within [0, 1]"},
    {"a camera without depth, with what it is laid over", "[camera]\nz_min_m=7\n",
     "f.toml:1:1: camera.z_max_m: must be greater than z_min_m"},
    {"a fault without device", "[[fault]]\nkind='silent'\n",
     "f.toml:1:1: fault[0].device: missing"},
    {"an unknown device", "[[fault]]\ndevice='arm8'\nkind='silent'\n",
     "f.toml:2:8: fault[0].device: must be tracer"},
    {"an unknown kind", "[[fault]]\ndevice='arm7'\nkind='tired'\n",
     "f.toml:3:6: fault[0].kind: must be absent"},
    {"a slip without end", "[[fault]]\ndevice='tracer'\nkind='slip'\n",
     "f.toml:1:1: fault[0].for_s: missing"},
    {"a table that is an array", "[[base]]\nslip=0.1\n", "f.toml:1:1: base: must be a table"},
    {"an array of tables that is a table", "[fault]\ndevice='arm1'\n",
     "f.toml:1:1: fault: must be an array of tables, [[fault]]"},
    {"broken syntax", "[camera]\nx = = 1\n", "f.toml:2:"},
};

TEST(LayOver, NamesThePlaceAndTheKeyOfWhatIsWrongAndChangesNothing) {
  for (const Bad& bad : kBad) {
    SCOPED_TRACE(bad.name);
    Conditions conditions = Given();
    const Errors errors = LayOver(bad.text, "f.toml", conditions);
    ASSERT_FALSE(errors.empty());
    EXPECT_TRUE(errors[0].starts_with(bad.expected)) << errors[0];
    EXPECT_EQ(conditions.camera.lost_fraction, 0.2);
    EXPECT_EQ(conditions.camera.z_min_m, CameraSpec{}.z_min_m);
    EXPECT_EQ(conditions.base.slip, 0.05);
    EXPECT_EQ(conditions.faults.size(), 1U);
  }
}

TEST(LayOver, SaysWhenThereIsNoSuchThing) {
  Conditions conditions;
  for (const std::string name : {"/nowhere/faults.toml", "pipes1", "/", ""}) {
    const Errors errors = LayOver(name, conditions);
    ASSERT_EQ(errors.size(), 1U) << name;
    EXPECT_EQ(errors[0], name + ": neither shipped faults nor a file that can be read");
  }
}

TEST(ShippedConditions, AreThereAndValid) {
  ASSERT_EQ(ShippedConditions().size(), 1U);
  EXPECT_EQ(ShippedConditions()[0].name, "rough");
  Conditions conditions = Given();
  EXPECT_EQ(LayOver("rough", conditions), Errors{});
  EXPECT_EQ(conditions.camera.noise_sigma_at_1m, 0.0057);
  EXPECT_EQ(conditions.camera.invalid_fraction, 0.05);
  EXPECT_EQ(conditions.camera.below_min_wrong_fraction, 0.5);
  EXPECT_EQ(conditions.camera.lost_fraction, 0.1);
  EXPECT_EQ(conditions.camera.rate_hz, 30);
  EXPECT_EQ(conditions.base.yaw_scale_slow, 1.06);
  EXPECT_EQ(conditions.base.yaw_scale_fast, 1.03);
  EXPECT_EQ(conditions.base.slip, 0.01);
  EXPECT_EQ(conditions.base.slip_sigma, 0.02);
  ASSERT_EQ(conditions.faults.size(), 2U);
  EXPECT_EQ(conditions.faults[1].device, "tracer");
  EXPECT_EQ(conditions.faults[1].kind, FaultKind::kSlip);
}

TEST(NameOfConditions, IsTheShippedNameOrTheFilesWithoutFolderAndExtension) {
  EXPECT_EQ(NameOfConditions("rough"), "rough");
  EXPECT_EQ(NameOfConditions("dust.toml"), "dust");
  EXPECT_EQ(NameOfConditions("/srv/faults/wet_floor.toml"), "wet_floor");
}

}  // namespace
}  // namespace pipewright::hil
