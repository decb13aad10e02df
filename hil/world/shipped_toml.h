// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "platform/toml/toml_source.h"

namespace pipewright::hil {

/// A TOML text in the binary.
struct ShippedToml {
  std::string_view name;
  std::string_view toml;
};

/// A shipped text by its name, else a file's.
/// @param a_shipped_one  what a name stands for, in the message that there is none
/// @returns nothing, and adds to `errors`, when there is neither or the file is over 4 MB
std::optional<TomlSource> FindToml(const std::string& name_or_file,
                                   const std::vector<ShippedToml>& shipped,
                                   const std::string& a_shipped_one,
                                   std::vector<std::string>& errors);

}  // namespace pipewright::hil
