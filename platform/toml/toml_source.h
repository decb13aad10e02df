// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pipewright {

class TomlTable;

struct TomlSource {
  std::string text;
  std::string directory;  ///< where files that it names are looked for; empty for a shipped text
};

/// A file's text.
/// @param what_it_is_not  why there may be none, in the message that it cannot be read
/// @returns nothing, and adds to `errors`, when it cannot be read or is over 4 MB
std::optional<TomlSource> ReadTomlFile(const std::string& file, const std::string& what_it_is_not,
                                       std::vector<std::string>& errors);

/// Hands the text's root to `read`; text that is not TOML is an error instead.
/// @param origin  the name in error messages
void ReadToml(std::string_view toml, const std::string& origin, std::vector<std::string>& errors,
              const std::function<void(TomlTable& root)>& read);

}  // namespace pipewright
