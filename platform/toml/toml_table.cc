// SPDX-License-Identifier: MIT
#include "platform/toml/toml_table.h"

#include <cmath>
#include <sstream>

namespace pipewright {
namespace {

std::string Range(double lo, double hi) {
  std::ostringstream text;
  text << "must be within [" << lo << ", " << hi << "]";
  return text.str();
}

}  // namespace

std::string TomlTable::PlaceOf(const toml::source_region& where) const {
  std::ostringstream text;
  text << origin_ << ":" << where.begin.line << ":" << where.begin.column << ": " << path_;
  return text.str();
}

std::string TomlTable::Where() const { return PlaceOf(table_.source()); }

void TomlTable::Report(const toml::source_region& where, std::string_view key,
                       const std::string& what) {
  std::ostringstream text;
  text << PlaceOf(where) << (path_.empty() || key.empty() ? "" : ".") << key << ": " << what;
  errors_.push_back(text.str());
}

void TomlTable::Error(std::string_view key, const std::string& what) {
  const toml::node* node = table_.get(key);
  Report(node != nullptr ? node->source() : table_.source(), key, what);
}

void TomlTable::Finish() {
  for (const auto& [key, node] : table_) {
    if (!asked_.contains(key.str())) {
      Report(key.source(), key.str(), "unknown key");
    }
  }
}

const toml::node* TomlTable::Find(std::string_view key, bool required) {
  asked_.emplace(key);
  const toml::node* node = table_.get(key);
  if (node == nullptr && required) {
    Report(table_.source(), key, "missing");
  }
  return node;
}

double TomlTable::NumberAt(const toml::node& node, std::string_view key, double lo, double hi) {
  if (!node.is_number()) {
    Report(node.source(), key, "must be a number");
    return 0;
  }
  const double value = *node.value<double>();
  if (!(value >= lo && value <= hi)) {
    Report(node.source(), key, Range(lo, hi));
    return 0;
  }
  return value;
}

double TomlTable::Number(std::string_view key, double lo, double hi,
                         std::optional<double> otherwise) {
  const toml::node* node = Find(key, !otherwise);
  return node == nullptr ? otherwise.value_or(0) : NumberAt(*node, key, lo, hi);
}

int TomlTable::Integer(std::string_view key, int lo, int hi, std::optional<int> otherwise) {
  const toml::node* node = Find(key, !otherwise);
  if (node == nullptr) {
    return otherwise.value_or(0);
  }
  if (!node->is_integer()) {
    Report(node->source(), key, "must be an integer");
    return 0;
  }
  return static_cast<int>(NumberAt(*node, key, lo, hi));
}

bool TomlTable::Bool(std::string_view key, bool otherwise) {
  const toml::node* node = Find(key, false);
  if (node == nullptr) {
    return otherwise;
  }
  if (!node->is_boolean()) {
    Report(node->source(), key, "must be true or false");
    return otherwise;
  }
  return *node->value<bool>();
}

std::string TomlTable::Text(std::string_view key, const std::optional<std::string>& otherwise) {
  const toml::node* node = Find(key, !otherwise);
  if (node == nullptr) {
    return otherwise.value_or("");
  }
  if (!node->is_string()) {
    Report(node->source(), key, "must be text");
    return "";
  }
  return *node->value<std::string>();
}

std::vector<double> TomlTable::Numbers(std::string_view key, int count, double lo, double hi,
                                       const std::optional<std::vector<double>>& otherwise) {
  const toml::node* node = Find(key, !otherwise);
  const auto size = static_cast<std::size_t>(count);
  if (node == nullptr) {
    return otherwise.value_or(std::vector<double>(size));
  }
  const toml::array* array = node->as_array();
  if (array == nullptr || array->size() != size) {
    Report(node->source(), key, "must be an array of " + std::to_string(count) + " numbers");
    return std::vector<double>(size);
  }
  std::vector<double> values;
  for (const toml::node& entry : *array) {
    values.push_back(NumberAt(entry, key, lo, hi));
  }
  return values;
}

Vector3d TomlTable::Vector(std::string_view key, double lo, double hi,
                           std::optional<Vector3d> otherwise) {
  std::optional<std::vector<double>> numbers;
  if (otherwise) {
    numbers = {otherwise->x(), otherwise->y(), otherwise->z()};
  }
  return Vector3d(Numbers(key, 3, lo, hi, numbers).data());
}

std::optional<TomlTable> TomlTable::Table(std::string_view key, bool required) {
  const toml::node* node = Find(key, required);
  if (node == nullptr) {
    return std::nullopt;
  }
  if (!node->is_table()) {
    Report(node->source(), key, "must be a table");
    return std::nullopt;
  }
  return TomlTable(*node->as_table(), path_ + (path_.empty() ? "" : ".") + std::string(key),
                   origin_, errors_);
}

std::vector<TomlTable> TomlTable::Tables(std::string_view key) {
  std::vector<TomlTable> tables;
  const toml::node* node = Find(key, false);
  if (node == nullptr) {
    return tables;
  }
  if (!node->is_array_of_tables()) {
    Report(node->source(), key, "must be an array of tables, [[" + std::string(key) + "]]");
    return tables;
  }
  int i = 0;
  for (const toml::node& entry : *node->as_array()) {
    tables.emplace_back(*entry.as_table(), std::string(key) + "[" + std::to_string(i++) + "]",
                        origin_, errors_);
  }
  return tables;
}

}  // namespace pipewright
