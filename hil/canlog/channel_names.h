// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace pipewright::hil {

/// The channels of a log, numbered as they are first met: interfaces of the kernel, or a tool's
/// channel numbers. At most 255; what comes after shares the number of "others".
class ChannelNames {
 public:
  static constexpr int kMost = 256;
  static constexpr std::size_t kNameBytes = 32;  ///< longer names are cut

  /// The number of `name`, which is that of the call before in most logs.
  std::uint8_t Number(std::string_view name) {
    return name == last_name_ ? last_ : Find(name.substr(0, kNameBytes));
  }
  std::string_view Name(int number) const { return names_[static_cast<std::size_t>(number)]; }
  int size() const { return static_cast<int>(names_.size()); }

 private:
  std::uint8_t Find(std::string_view name);

  std::vector<std::string> names_;
  std::string last_name_;
  std::uint8_t last_ = 0;
};

}  // namespace pipewright::hil
