// SPDX-License-Identifier: MIT
#include "hil/plant/robot_description.h"

#include <gtest/gtest.h>

#include <cmath>

#include "hil/plant/kdl_tree.h"

namespace pipewright::hil {
namespace {

struct Bounds {
  Vector3d lo = Vector3d::Constant(1e9);
  Vector3d hi = Vector3d::Constant(-1e9);
};

/// The exact box of a box, cylinder or sphere in its link's frame.
void Include(const CollisionShape& shape, Bounds& bounds) {
  const Matrix3d R = shape.X_LG.linear();
  Vector3d half = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    switch (shape.kind) {
      case CollisionShape::Kind::kBox:
        half(i) = R.row(i).cwiseAbs().dot(shape.size_m) / 2;
        break;
      case CollisionShape::Kind::kCylinder:
        half(i) = std::abs(R(i, 2)) * shape.size_m.z() / 2 +
                  shape.size_m.x() * std::sqrt(std::max(0.0, 1 - R(i, 2) * R(i, 2)));
        break;
      case CollisionShape::Kind::kSphere:
        half(i) = shape.size_m.x();
        break;
      case CollisionShape::Kind::kMesh:
        FAIL() << "no meshes in this robot";
    }
  }
  bounds.lo = bounds.lo.cwiseMin(shape.X_LG.translation() - half);
  bounds.hi = bounds.hi.cwiseMax(shape.X_LG.translation() + half);
}

TEST(TracerUf7, HasTheChainFromTheFloorToCameraAndProbe) {
  const RobotDescription robot = TracerUf7Description();
  EXPECT_EQ(robot.name, "tracer_uf7");
  const std::vector<std::string> links{"base_link", "arm_base", "link1",  "link2",
                                       "link3",     "link4",    "link5",  "link6",
                                       "link7",     "tool",     "camera", "probe"};
  EXPECT_EQ(robot.links, links);
  ASSERT_EQ(robot.joints.size(), 11U);
  EXPECT_EQ(robot.MovingJoints().size(), 7U);
  EXPECT_EQ(robot.LinkIndex("link4"), 5);
  EXPECT_EQ(robot.LinkIndex("link8"), -1);
}

TEST(TracerUf7, HasTheVendorsJointLimits) {
  const RobotDescription robot = TracerUf7Description();
  const std::vector<const JointDescription*> joints = robot.MovingJoints();
  struct Case {
    double lower, upper, effort;
  };
  const Case cases[] = {{-2 * M_PI, 2 * M_PI, 50}, {-2.059488, 2.094395, 50},
                        {-2 * M_PI, 2 * M_PI, 30}, {-0.191986, 3.92699, 30},
                        {-2 * M_PI, 2 * M_PI, 30}, {-1.692969, M_PI, 20},
                        {-2 * M_PI, 2 * M_PI, 20}};
  for (std::size_t i = 0; i < 7; ++i) {
    SCOPED_TRACE(joints[i]->name);
    EXPECT_DOUBLE_EQ(joints[i]->lower, cases[i].lower);
    EXPECT_DOUBLE_EQ(joints[i]->upper, cases[i].upper);
    EXPECT_DOUBLE_EQ(joints[i]->effort_max, cases[i].effort);
    EXPECT_DOUBLE_EQ(joints[i]->velocity_max, M_PI);
    EXPECT_EQ(joints[i]->axis_J, Vector3d::UnitZ());
  }
}

// The boxes were measured on the vendor's collision meshes. 5 mm: the meshes are rounder than
// cylinders and boxes.
TEST(TracerUf7, EachLinkFillsTheBoxOfTheVendorsMesh) {
  struct Case {
    const char* link;
    Vector3d lo, hi;
  };
  const Case cases[] = {
      {"arm_base", {-.063, -.063, 0}, {.063, .063, .150}},
      {"link1", {-.048, -.057, -.116}, {.048, .059, .049}},
      {"link2", {-.048, -.183, -.044}, {.048, .048, .118}},
      {"link3", {-.044, -.046, -.110}, {.097, .069, .044}},
      {"link4", {-.044, -.162, -.045}, {.123, .044, .109}},
      {"link5", {-.045, -.045, -.182}, {.045, .086, .038}},
      {"link6", {-.039, -.038, -.039}, {.115, .067, .060}},
      {"link7", {-.039, -.055, -.031}, {.039, .039, 0}},
  };
  const RobotDescription robot = TracerUf7Description();
  for (const Case& c : cases) {
    SCOPED_TRACE(c.link);
    Bounds bounds;
    for (const CollisionShape& shape : robot.shapes) {
      if (shape.link == c.link) {
        Include(shape, bounds);
      }
    }
    EXPECT_LT((bounds.lo - c.lo).cwiseAbs().maxCoeff(), 0.005) << bounds.lo.transpose();
    EXPECT_LT((bounds.hi - c.hi).cwiseAbs().maxCoeff(), 0.005) << bounds.hi.transpose();
  }
}

TEST(TracerUf7, ThePlatformHasTheManualsOutlineAndGroundClearance) {
  const RobotDescription robot = TracerUf7Description();
  const CollisionShape& platform = robot.shapes[0];
  EXPECT_EQ(platform.name, "platform");
  EXPECT_EQ(platform.size_m, Vector3d(0.700, 0.500, 0.127));
  const double z = platform.X_LG.translation().z();
  EXPECT_NEAR(z - platform.size_m.z() / 2, 0.036, 1e-12);
  EXPECT_NEAR(z + platform.size_m.z() / 2, 0.163, 1e-12);
}

TEST(TracerUf7, ItsKdlTreeHasSevenJointsAndASegmentALink) {
  const KDL::Tree tree = ToKdlTree(TracerUf7Description());
  EXPECT_EQ(tree.getNrOfJoints(), 7U);
  EXPECT_EQ(tree.getNrOfSegments(), 11U);
}

TEST(ParseUrdf, ReadsEveryGeometryAndJointKind) {
  const char* text = R"(<robot name="r">
    <link name="b"><collision><origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>
      <geometry><mesh filename="part.stl" scale="0.001 0.001 0.001"/></geometry></collision></link>
    <link name="a"><collision name="ball"><geometry><sphere radius="0.2"/></geometry></collision></link>
    <link name="c"/>
    <joint name="jc" type="prismatic"><parent link="b"/><child link="c"/><axis xyz="0 0 2"/>
      <limit lower="0" upper="1" effort="1" velocity="1"/></joint>
    <joint name="jb" type="continuous"><parent link="a"/><child link="b"/></joint>
  </robot>)";
  DescriptionError error;
  const std::optional<RobotDescription> robot = ParseUrdf(text, "r.urdf", error);
  ASSERT_TRUE(robot.has_value()) << error.Text();
  EXPECT_EQ(robot->links, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(robot->joints[0].name, "jb");
  EXPECT_TRUE(std::isinf(robot->joints[0].upper));
  EXPECT_EQ(robot->joints[0].axis_J, Vector3d::UnitX());
  EXPECT_EQ(robot->joints[1].axis_J, Vector3d::UnitZ());
  EXPECT_EQ(robot->shapes[0].mesh_file, "part.stl");
  EXPECT_NEAR((robot->shapes[0].X_LG * Vector3d(1, 0, 0) - Vector3d(1, 1, 0)).norm(), 0, 1e-15);
  EXPECT_EQ(robot->shapes[1].size_m, Vector3d::Constant(0.2));
}

TEST(ParseUrdf, NamesTheLineAndElementOfWhatIsWrong) {
  struct Case {
    const char* body;  // begins on line 2
    int line;
    const char* element;
    const char* what;
  };
  const Case cases[] = {
      {"<link/>", 2, "link", "'name' is missing"},
      {"<link name='a'/>\n<link name='a'/>", 3, "link", "a second link"},
      {"", 1, "robot", "no <link>"},
      {"<link name='a'><collision/></link>", 2, "collision", "<geometry> is missing"},
      {"<link name='a'><collision><geometry/></collision></link>", 2, "geometry", "no <box>"},
      {"<link name='a'><collision><geometry>\n<box size='1 2'/></geometry></collision></link>", 3,
       "box", "not 3 numbers"},
      {"<link name='a'><collision><geometry><box size='1 2 0'/></geometry></collision></link>", 2,
       "box", "must be positive"},
      {"<link name='a'><collision><geometry><sphere radius='x'/></geometry></collision></link>", 2,
       "sphere", "not 1 number"},
      {"<link name='a'><collision><geometry><cylinder radius='1' length='-1'/></geometry>"
       "</collision></link>",
       2, "cylinder", "must be positive"},
      {"<link name='a'/><joint name='j' type='ball'/>", 2, "joint", "'ball'"},
      {"<link name='a'/><link name='b'/>\n<joint name='j' type='revolute'>"
       "<parent link='a'/><child link='b'/></joint>",
       3, "joint", "<limit> is missing"},
      {"<link name='a'/><link name='b'/><joint name='j' type='revolute'>"
       "<parent link='a'/><child link='b'/>\n<limit lower='1' upper='0' effort='1' velocity='1'/>"
       "</joint>",
       3, "limit", "below 'upper'"},
      {"<link name='a'/><joint name='j' type='fixed'><parent link='a'/><child link='z'/></joint>",
       2, "joint", "'z', which is not there"},
      {"<link name='a'/><link name='b'/>", 1, "robot", "two root links"},
      {"<link name='a'/><link name='b'/><joint name='j' type='fixed'><parent link='a'/>"
       "<child link='b'/></joint><joint name='k' type='fixed'><parent link='b'/>"
       "<child link='a'/></joint>",
       1, "robot", "loop"},
      {"<link name='a'/><link name='b'/><link name='c'/>"
       "<joint name='j' type='fixed'><parent link='b'/><child link='c'/></joint>"
       "<joint name='k' type='fixed'><parent link='c'/><child link='b'/></joint>",
       1, "robot", "loop"},
      {"<link name='a'/><link name='b'/><joint name='j' type='fixed'><parent link='a'/>"
       "<child link='b'/></joint>\n<joint name='k' type='fixed'><parent link='a'/>"
       "<child link='b'/></joint>",
       3, "joint", "already has a parent"},
      {"<link name='a'/><link name='b'/><joint name='j' type='continuous'><parent link='a'/>"
       "<child link='b'/><axis xyz='0 0 0'/></joint>",
       2, "axis", "no direction"},
      {"<link name='a'>", 2, "xml", "MISMATCHED"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.body);
    DescriptionError error;
    const std::string text = std::string("<robot name='r'>\n") + c.body + "</robot>";
    EXPECT_FALSE(ParseUrdf(text, "r.urdf", error).has_value());
    EXPECT_EQ(error.file, "r.urdf");
    EXPECT_EQ(error.line, c.line);
    EXPECT_EQ(error.element, c.element);
    EXPECT_NE(error.what.find(c.what), std::string::npos) << error.what;
  }
  DescriptionError error;
  EXPECT_FALSE(ParseUrdf("<sdf/>", "f", error).has_value());
  EXPECT_EQ(error.Text(), "f:1: <sdf>: the root element is not <robot>");
}

}  // namespace
}  // namespace pipewright::hil
