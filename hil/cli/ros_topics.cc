// SPDX-License-Identifier: MIT
#include "hil/cli/ros_topics.h"

#include <algorithm>

namespace pipewright::hil {

std::uint16_t RosTopics::Channel(const std::string& topic, const RosType& type) {
  const auto found = std::find_if(topics_.begin(), topics_.end(),
                                  [&topic](const Figures& other) { return other.topic == topic; });
  if (found != topics_.end()) {
    return static_cast<std::uint16_t>(found - topics_.begin());
  }
  std::uint16_t& schema = schemas_[type.name];
  if (schema == 0) {
    schema = to_.AddSchema(type.name, "ros2msg", type.Definition());
  }
  topics_.push_back({topic, type.name});
  return to_.AddChannel(schema, topic, "cdr");
}

std::vector<RosTopics::Figures> RosTopics::All() const {
  std::vector<Figures> all = topics_;
  for (std::size_t channel = 0; channel < all.size(); ++channel) {
    all[channel].messages = to_.messages(static_cast<std::uint16_t>(channel));
  }
  return all;
}

}  // namespace pipewright::hil
