// SPDX-License-Identifier: MIT
#pragma once

#include <toml++/toml.h>

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "platform/core/frames.h"

namespace pipewright {

/// A table of a TOML file that is read strictly: each getter says what a key must be, and Finish()
/// objects to every key nobody asked for. Errors are collected, "file:line:column: key: what";
/// after one the getter returns its default, or zero.
class TomlTable {
 public:
  /// @param path  the table's name in messages, empty for the file's root
  TomlTable(const toml::table& table, std::string path, const std::string& origin,
            std::vector<std::string>& errors)
      : table_(table), path_(std::move(path)), origin_(origin), errors_(errors) {}

  /// Finite and within [lo, hi]. Integers count as numbers.
  double Number(std::string_view key, double lo, double hi, std::optional<double> otherwise = {});
  int Integer(std::string_view key, int lo, int hi, std::optional<int> otherwise = {});
  bool Bool(std::string_view key, bool otherwise);
  std::string Text(std::string_view key, const std::optional<std::string>& otherwise = {});
  Vector3d Vector(std::string_view key, double lo, double hi,
                  std::optional<Vector3d> otherwise = {});
  std::vector<double> Numbers(std::string_view key, int count, double lo, double hi,
                              const std::optional<std::vector<double>>& otherwise = {});

  /// A sub-table; missing: an error when required, else nothing.
  std::optional<TomlTable> Table(std::string_view key, bool required);
  /// An array of tables; missing: empty.
  std::vector<TomlTable> Tables(std::string_view key);

  bool Has(std::string_view key) const { return table_.contains(key); }
  /// Reports that a key's value (or, without it, the table) is wrong.
  void Error(std::string_view key, const std::string& what);
  /// "file:line:column: path" of the table, for what is found wrong later.
  std::string Where() const;
  /// Reports every key that was never asked for.
  void Finish();

 private:
  const toml::node* Find(std::string_view key, bool required);
  std::string PlaceOf(const toml::source_region& where) const;
  void Report(const toml::source_region& where, std::string_view key, const std::string& what);
  double NumberAt(const toml::node& node, std::string_view key, double lo, double hi);

  const toml::table& table_;
  std::string path_;
  const std::string& origin_;
  std::vector<std::string>& errors_;
  std::set<std::string, std::less<>> asked_;
};

}  // namespace pipewright
