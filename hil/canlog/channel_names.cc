// SPDX-License-Identifier: MIT
#include "hil/canlog/channel_names.h"

#include <algorithm>

namespace pipewright::hil {

std::uint8_t ChannelNames::Find(std::string_view name) {
  const auto found = std::find(names_.begin(), names_.end(), name);
  std::size_t number = static_cast<std::size_t>(found - names_.begin());
  if (found == names_.end()) {
    if (names_.size() < kMost) {
      names_.emplace_back(names_.size() + 1 < kMost ? name : "others");
    }
    number = names_.size() - 1;
  }
  last_name_ = name;
  last_ = static_cast<std::uint8_t>(number);
  return last_;
}

}  // namespace pipewright::hil
