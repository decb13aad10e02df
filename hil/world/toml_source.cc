// SPDX-License-Identifier: MIT
#include "hil/world/toml_source.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include "hil/world/toml_table.h"

namespace pipewright::hil {
namespace {

constexpr std::uintmax_t kMaxFileBytes = 4'000'000;

}  // namespace

std::optional<TomlSource> FindToml(const std::string& name_or_file,
                                   const std::vector<ShippedToml>& shipped,
                                   const std::string& a_shipped_one,
                                   std::vector<std::string>& errors) {
  for (const ShippedToml& one : shipped) {
    if (one.name == name_or_file) {
      return TomlSource{std::string(one.toml), ""};
    }
  }
  const std::filesystem::path path(name_or_file);
  std::error_code failed;
  const std::uintmax_t bytes = std::filesystem::file_size(path, failed);
  std::ifstream file(path, std::ios::binary);
  if (failed || !file) {
    errors.push_back(name_or_file + ": neither " + a_shipped_one + " nor a file that can be read");
    return std::nullopt;
  }
  if (bytes > kMaxFileBytes) {
    errors.push_back(name_or_file + ": is longer than it may be (4 MB)");
    return std::nullopt;
  }
  std::ostringstream text;
  text << file.rdbuf();
  return TomlSource{text.str(), path.parent_path().string()};
}

void ReadToml(std::string_view toml, const std::string& origin, std::vector<std::string>& errors,
              const std::function<void(TomlTable& root)>& read) {
  try {
    const toml::table table = toml::parse(toml, origin);
    TomlTable root(table, "", origin, errors);
    read(root);
  } catch (const toml::parse_error& error) {
    std::ostringstream text;
    text << origin << ":" << error.source().begin.line << ":" << error.source().begin.column << ": "
         << error.description();
    errors.push_back(text.str());
  }
}

}  // namespace pipewright::hil
