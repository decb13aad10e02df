// SPDX-License-Identifier: MIT
#include <tinyxml2.h>

#include <cmath>
#include <limits>
#include <locale>
#include <map>
#include <set>
#include <sstream>

#include "hil/plant/robot_description.h"

namespace pipewright::hil {
namespace {

using tinyxml2::XMLElement;

/// Thrown and caught in this file alone.
struct Wrong {
  int line;
  std::string element;
  std::string what;
};

[[noreturn]] void Fail(const XMLElement& at, const std::string& what) {
  throw Wrong{at.GetLineNum(), at.Name(), what};
}

std::string Attribute(const XMLElement& at, const char* name) {
  const char* text = at.Attribute(name);
  if (text == nullptr || *text == '\0') {
    Fail(at, std::string("attribute '") + name + "' is missing");
  }
  return text;
}

/// Exactly n finite numbers, whatever the program's locale.
std::vector<double> Numbers(const XMLElement& at, const char* name, int n) {
  const std::string text = Attribute(at, name);
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  std::vector<double> values;
  for (double value = 0; in >> value;) {
    values.push_back(value);
  }
  if (!in.eof() || static_cast<int>(values.size()) != n) {
    Fail(at, std::string("attribute '") + name + "' is not " + std::to_string(n) +
                 (n == 1 ? " number" : " numbers") + ": '" + text + "'");
  }
  return values;
}

double Number(const XMLElement& at, const char* name) { return Numbers(at, name, 1)[0]; }

double Positive(const XMLElement& at, const char* name) {
  const double value = Number(at, name);
  if (value <= 0) {
    Fail(at, std::string("attribute '") + name + "' must be positive");
  }
  return value;
}

Vector3d Triple(const XMLElement& at, const char* name, const Vector3d& otherwise) {
  if (at.Attribute(name) == nullptr) {
    return otherwise;
  }
  const std::vector<double> v = Numbers(at, name, 3);
  return {v[0], v[1], v[2]};
}

const XMLElement& Child(const XMLElement& at, const char* name) {
  const XMLElement* child = at.FirstChildElement(name);
  if (child == nullptr) {
    Fail(at, std::string("element <") + name + "> is missing");
  }
  return *child;
}

/// rpy is Rz(yaw) Ry(pitch) Rx(roll).
Isometry3d Origin(const XMLElement& at) {
  Isometry3d X = Isometry3d::Identity();
  if (const XMLElement* origin = at.FirstChildElement("origin")) {
    const Vector3d rpy = Triple(*origin, "rpy", Vector3d::Zero());
    X.translation() = Triple(*origin, "xyz", Vector3d::Zero());
    X.linear() = (Eigen::AngleAxisd(rpy.z(), Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(rpy.y(), Vector3d::UnitY()) *
                  Eigen::AngleAxisd(rpy.x(), Vector3d::UnitX()))
                     .toRotationMatrix();
  }
  return X;
}

CollisionShape ReadShape(const XMLElement& collision, const std::string& link) {
  using Kind = CollisionShape::Kind;
  CollisionShape shape;
  shape.link = link;
  shape.name = collision.Attribute("name") != nullptr ? collision.Attribute("name") : "";
  shape.X_LG = Origin(collision);
  const XMLElement& geometry = Child(collision, "geometry");
  if (const XMLElement* box = geometry.FirstChildElement("box")) {
    const std::vector<double> v = Numbers(*box, "size", 3);
    shape.kind = Kind::kBox;
    shape.size_m = {v[0], v[1], v[2]};
    if (!(shape.size_m.minCoeff() > 0)) {
      Fail(*box, "attribute 'size' must be positive");
    }
  } else if (const XMLElement* cylinder = geometry.FirstChildElement("cylinder")) {
    const double radius = Positive(*cylinder, "radius");
    shape.kind = Kind::kCylinder;
    shape.size_m = {radius, radius, Positive(*cylinder, "length")};
  } else if (const XMLElement* sphere = geometry.FirstChildElement("sphere")) {
    shape.kind = Kind::kSphere;
    shape.size_m.setConstant(Positive(*sphere, "radius"));
  } else if (const XMLElement* mesh = geometry.FirstChildElement("mesh")) {
    shape.kind = Kind::kMesh;
    shape.mesh_file = Attribute(*mesh, "filename");
    shape.size_m = Triple(*mesh, "scale", Vector3d::Ones());
  } else {
    Fail(geometry, "no <box>, <cylinder>, <sphere> or <mesh> in it");
  }
  return shape;
}

JointDescription::Kind ReadKind(const XMLElement& element) {
  using Kind = JointDescription::Kind;
  static const std::map<std::string, Kind> kKinds{{"fixed", Kind::kFixed},
                                                  {"revolute", Kind::kRevolute},
                                                  {"continuous", Kind::kContinuous},
                                                  {"prismatic", Kind::kPrismatic}};
  const std::string type = Attribute(element, "type");
  const auto kind = kKinds.find(type);
  if (kind == kKinds.end()) {
    Fail(element, "joint type '" + type + "' is not fixed, revolute, continuous or prismatic");
  }
  return kind->second;
}

void ReadLimit(const XMLElement& element, JointDescription& joint) {
  using Kind = JointDescription::Kind;
  const bool bounded = joint.kind == Kind::kRevolute || joint.kind == Kind::kPrismatic;
  const XMLElement* limit = element.FirstChildElement("limit");
  if (limit == nullptr) {
    if (bounded) {
      Fail(element, "element <limit> is missing");
    }
    return;
  }
  joint.velocity_max = Positive(*limit, "velocity");
  joint.effort_max = Positive(*limit, "effort");
  if (bounded) {
    joint.lower = Number(*limit, "lower");
    joint.upper = Number(*limit, "upper");
    if (joint.lower >= joint.upper) {
      Fail(*limit, "'lower' must be below 'upper'");
    }
  }
}

JointDescription ReadJoint(const XMLElement& element) {
  using Kind = JointDescription::Kind;
  JointDescription joint;
  joint.name = Attribute(element, "name");
  joint.kind = ReadKind(element);
  joint.parent = Attribute(Child(element, "parent"), "link");
  joint.child = Attribute(Child(element, "child"), "link");
  joint.X_PJ = Origin(element);
  if (const XMLElement* axis = element.FirstChildElement("axis")) {
    joint.axis_J = Triple(*axis, "xyz", Vector3d::UnitX());
    if (joint.axis_J.norm() < 1e-9) {
      Fail(*axis, "attribute 'xyz' has no direction");
    }
    joint.axis_J.normalize();
  }
  if (joint.kind == Kind::kContinuous) {
    joint.lower = -std::numeric_limits<double>::infinity();
    joint.upper = std::numeric_limits<double>::infinity();
  }
  if (joint.kind != Kind::kFixed) {
    ReadLimit(element, joint);
  }
  return joint;
}

/// Orders links and joints root first; what cannot be reached from the one root is a loop.
void SortTree(const XMLElement& root, const std::vector<std::string>& links,
              const std::vector<std::pair<JointDescription, const XMLElement*>>& joints,
              RobotDescription& robot) {
  std::map<std::string, const XMLElement*> parent_of;
  const std::set<std::string> known(links.begin(), links.end());
  for (const auto& [joint, element] : joints) {
    for (const std::string& link : {joint.parent, joint.child}) {
      if (known.count(link) == 0) {
        Fail(*element, "joint '" + joint.name + "' names link '" + link + "', which is not there");
      }
    }
    if (!parent_of.emplace(joint.child, element).second) {
      Fail(*element, "link '" + joint.child + "' already has a parent");
    }
  }
  for (const std::string& link : links) {
    if (parent_of.count(link) == 0) {
      if (!robot.links.empty()) {
        Fail(root, "two root links: '" + robot.links[0] + "' and '" + link + "'");
      }
      robot.links.push_back(link);
    }
  }
  if (robot.links.empty()) {
    Fail(root, links.empty() ? "no <link> in it" : "no root link: the joints form a loop");
  }
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    for (const auto& [joint, element] : joints) {
      if (joint.parent == robot.links[i]) {
        robot.joints.push_back(joint);
        robot.links.push_back(joint.child);
      }
    }
  }
  if (robot.links.size() != links.size()) {
    Fail(root, "the joints form a loop");
  }
}

RobotDescription ReadRobot(const XMLElement& root) {
  RobotDescription robot;
  robot.name = Attribute(root, "name");
  std::vector<std::string> links;
  std::set<std::string> names;
  for (const XMLElement* link = root.FirstChildElement("link"); link != nullptr;
       link = link->NextSiblingElement("link")) {
    const std::string name = Attribute(*link, "name");
    if (!names.insert(name).second) {
      Fail(*link, "a second link '" + name + "'");
    }
    links.push_back(name);
    for (const XMLElement* collision = link->FirstChildElement("collision"); collision != nullptr;
         collision = collision->NextSiblingElement("collision")) {
      robot.shapes.push_back(ReadShape(*collision, name));
    }
  }
  names.clear();
  std::vector<std::pair<JointDescription, const XMLElement*>> joints;
  for (const XMLElement* joint = root.FirstChildElement("joint"); joint != nullptr;
       joint = joint->NextSiblingElement("joint")) {
    joints.emplace_back(ReadJoint(*joint), joint);
    if (!names.insert(joints.back().first.name).second) {
      Fail(*joint, "a second joint '" + joints.back().first.name + "'");
    }
  }
  SortTree(root, links, joints, robot);
  return robot;
}

}  // namespace

std::optional<RobotDescription> ParseUrdf(std::string_view text, const std::string& file,
                                          DescriptionError& error) {
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    error = {file, document.ErrorLineNum(), "xml", document.ErrorName()};
    return std::nullopt;
  }
  const XMLElement* root = document.RootElement();
  if (root == nullptr || std::string_view(root->Name()) != "robot") {
    error = {file, root == nullptr ? 0 : root->GetLineNum(), root == nullptr ? "xml" : root->Name(),
             "the root element is not <robot>"};
    return std::nullopt;
  }
  try {
    return ReadRobot(*root);
  } catch (const Wrong& wrong) {
    error = {file, wrong.line, wrong.element, wrong.what};
    return std::nullopt;
  }
}

}  // namespace pipewright::hil
