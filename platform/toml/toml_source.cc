// SPDX-License-Identifier: MIT
#include "platform/toml/toml_source.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include "platform/toml/toml_table.h"

namespace pipewright {
namespace {

constexpr std::uintmax_t kMaxFileBytes = 4'000'000;

}  // namespace

std::optional<TomlSource> ReadTomlFile(const std::string& file, const std::string& what_it_is_not,
                                       std::vector<std::string>& errors) {
  const std::filesystem::path path(file);
  std::error_code failed;
  const std::uintmax_t bytes = std::filesystem::file_size(path, failed);
  std::ifstream in(path, std::ios::binary);
  if (failed || !in) {
    errors.push_back(file + ": " + what_it_is_not);
    return std::nullopt;
  }
  if (bytes > kMaxFileBytes) {
    errors.push_back(file + ": is longer than it may be (4 MB)");
    return std::nullopt;
  }
  std::ostringstream text;
  text << in.rdbuf();
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

}  // namespace pipewright
