// SPDX-License-Identifier: MIT
#include "hil/world/shipped_toml.h"

namespace pipewright::hil {

std::optional<TomlSource> FindToml(const std::string& name_or_file,
                                   const std::vector<ShippedToml>& shipped,
                                   const std::string& a_shipped_one,
                                   std::vector<std::string>& errors) {
  for (const ShippedToml& one : shipped) {
    if (one.name == name_or_file) {
      return TomlSource{std::string(one.toml), ""};
    }
  }
  return ReadTomlFile(name_or_file, "neither " + a_shipped_one + " nor a file that can be read",
                      errors);
}

}  // namespace pipewright::hil
