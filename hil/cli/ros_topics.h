// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "hil/mcap/mcap_writer.h"
#include "hil/mcap/ros_messages.h"

namespace pipewright::hil {

/// The topics of an MCAP file of ROS 2 messages. A topic is one channel, whoever writes to it.
class RosTopics {
 public:
  explicit RosTopics(McapWriter& to) : to_(to) {}

  /// The topic's channel, which the file has from the first call on.
  std::uint16_t Channel(const std::string& topic, const RosType& type);
  void Write(std::uint16_t channel, std::int64_t time_ns, const CdrWriter& message) {
    to_.Write(channel, time_ns, message.bytes());
  }

  struct Figures {
    std::string topic;
    std::string_view type;
    std::uint64_t messages = 0;
  };
  /// In the order in which they were first asked for.
  std::vector<Figures> All() const;

 private:
  McapWriter& to_;
  std::map<std::string_view, std::uint16_t> schemas_;  ///< by the name of the type
  std::vector<Figures> topics_;                        ///< by MCAP channel
};

}  // namespace pipewright::hil
