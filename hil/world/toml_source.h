// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pipewright::hil {

class TomlTable;

/// A TOML text in the binary.
struct ShippedToml {
  std::string_view name;
  std::string_view toml;
};

struct TomlSource {
  std::string text;
  std::string directory;  ///< where files that it names are looked for; empty for a shipped text
};

/// A shipped text by its name, else a file's.
/// @param a_shipped_one  what a name stands for, in the message that there is none
/// @returns nothing, and adds to `errors`, when there is neither or the file is over 4 MB
std::optional<TomlSource> FindToml(const std::string& name_or_file,
                                   const std::vector<ShippedToml>& shipped,
                                   const std::string& a_shipped_one,
                                   std::vector<std::string>& errors);

/// Hands the text's root to `read`; text that is not TOML is an error instead.
/// @param origin  the name in error messages
void ReadToml(std::string_view toml, const std::string& origin, std::vector<std::string>& errors,
              const std::function<void(TomlTable& root)>& read);

}  // namespace pipewright::hil
