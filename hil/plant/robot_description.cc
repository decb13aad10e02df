// SPDX-License-Identifier: MIT
#include "hil/plant/robot_description.h"

#include <cassert>

#include "embedded/TracerUf7Urdf.h"

namespace pipewright::hil {

int RobotDescription::LinkIndex(std::string_view link) const {
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (links[i] == link) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

std::vector<const JointDescription*> RobotDescription::MovingJoints() const {
  std::vector<const JointDescription*> moving;
  for (const JointDescription& joint : joints) {
    if (joint.kind != JointDescription::Kind::kFixed) {
      moving.push_back(&joint);
    }
  }
  return moving;
}

std::string DescriptionError::Text() const {
  return file + ":" + std::to_string(line) + ": <" + element + ">: " + what;
}

std::string_view TracerUf7Urdf() { return embedded::TracerUf7Urdf(); }

RobotDescription TracerUf7Description() {
  DescriptionError error;
  std::optional<RobotDescription> robot = ParseUrdf(TracerUf7Urdf(), "tracer_uf7.urdf", error);
  assert(robot.has_value());
  return *std::move(robot);
}

}  // namespace pipewright::hil
