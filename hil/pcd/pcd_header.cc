// SPDX-License-Identifier: MIT
#include "hil/pcd/pcd_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

namespace pipewright::hil {
namespace {

constexpr int kMostFields = 256;
constexpr int kMostPoints = 1 << 28;

std::vector<std::string_view> Words(std::string_view line) {
  std::vector<std::string_view> words;
  constexpr std::string_view kBlank = " \t\r";
  for (std::size_t at = line.find_first_not_of(kBlank); at < line.size();) {
    const std::size_t end = std::min(line.find_first_of(kBlank, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlank, end);
  }
  return words;
}

std::optional<int> ToInt(std::string_view word, int least, int most) {
  int value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  const bool whole = error == std::errc() && end == word.data() + word.size();
  return whole && least <= value && value <= most ? std::optional<int>(value) : std::nullopt;
}

/// Takes the header line by line; after the first error it keeps that error.
class HeaderParser {
 public:
  explicit HeaderParser(std::string_view bytes) : bytes_(bytes) {}

  PcdHeader Parse() {
    while (header_.error.empty() && !done_) {
      TakeLine();
    }
    if (header_.error.empty()) {
      CheckWhole();
    }
    return header_;
  }

 private:
  void TakeLine() {
    const std::size_t end = bytes_.find('\n', header_.body);
    if (end == std::string_view::npos) {
      header_.error = fmt::format("line {}: the header ends without DATA", header_.lines + 1);
      return;
    }
    ++header_.lines;
    const std::string_view line = bytes_.substr(header_.body, end - header_.body);
    header_.body = end + 1;
    const std::vector<std::string_view> words = Words(line);
    if (!words.empty() && words[0][0] != '#') {
      TakeKey(words[0], {words.begin() + 1, words.end()});
    }
  }

  void TakeKey(std::string_view key, const std::vector<std::string_view>& values) {
    if (key == "FIELDS" || key == "COLUMNS") {
      TakeNames(values);
    } else if (key == "SIZE") {
      TakeEach(key, values, [](PcdField& field, std::string_view word) {
        field.size = ToInt(word, 1, 8).value_or(0);
        return field.size == 1 || field.size == 2 || field.size == 4 || field.size == 8;
      });
    } else if (key == "TYPE") {
      TakeEach(key, values, [](PcdField& field, std::string_view word) {
        field.type = word[0];
        return word == "F" || word == "I" || word == "U";
      });
    } else if (key == "COUNT") {
      TakeEach(key, values, [](PcdField& field, std::string_view word) {
        field.count = ToInt(word, 1, 1 << 16).value_or(0);
        return field.count > 0;
      });
    } else if (key == "WIDTH" || key == "HEIGHT" || key == "POINTS") {
      const auto value = values.size() == 1 ? ToInt(values[0], 1, kMostPoints) : std::nullopt;
      if (!value) {
        Refuse(fmt::format("{} is not one whole number from 1 to {}", key, kMostPoints));
        return;
      }
      (key == "WIDTH" ? header_.width : key == "HEIGHT" ? header_.height : points_) = *value;
    } else if (key == "DATA") {
      TakeData(values);
    } else if (key != "VERSION" && key != "VIEWPOINT") {
      Refuse(fmt::format("'{}' is no key of a PCD header", key.substr(0, 20)));
    }
  }

  void TakeNames(const std::vector<std::string_view>& values) {
    if (values.empty() || values.size() > kMostFields || !header_.fields.empty()) {
      Refuse(fmt::format("FIELDS must name 1 to {} fields, once", kMostFields));
      return;
    }
    for (const std::string_view name : values) {
      if (name != "_" && header_.Find(name) >= 0) {
        Refuse(fmt::format("field {} stands twice", name));
        return;
      }
      header_.fields.push_back({std::string(name)});
    }
  }

  template <typename Take>
  void TakeEach(std::string_view key, const std::vector<std::string_view>& values,
                const Take& take) {
    if (values.size() != header_.fields.size() || values.empty()) {
      Refuse(
          fmt::format("{} has {} values for {} fields", key, values.size(), header_.fields.size()));
      return;
    }
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (!take(header_.fields[k], values[k])) {
        Refuse(fmt::format("field {}: {} '{}' makes no sense", header_.fields[k].name, key,
                           values[k].substr(0, 20)));
        return;
      }
    }
  }

  void TakeData(const std::vector<std::string_view>& values) {
    const std::string_view word = values.size() == 1 ? values[0] : std::string_view();
    done_ = true;
    if (word == "ascii") {
      header_.data = PcdData::kAscii;
    } else if (word == "binary") {
      header_.data = PcdData::kBinary;
    } else if (word == "binary_compressed") {
      header_.data = PcdData::kCompressed;
    } else {
      Refuse("DATA is none of ascii, binary, binary_compressed");
    }
  }

  void CheckWhole() {
    if (header_.width == 0 && header_.height == 0 && points_ > 0) {
      header_.width = points_;
      header_.height = 1;
    }
    const auto missing = [this](const char* key) {
      Refuse(fmt::format("{} is missing before DATA", key));
    };
    if (header_.fields.empty()) {
      missing("FIELDS");
    } else if (header_.fields[0].size == 0) {
      missing("SIZE");
    } else if (header_.fields[0].type == 0) {
      missing("TYPE");
    } else if (header_.width == 0) {
      missing("WIDTH");
    } else if (header_.height == 0) {
      missing("HEIGHT");
    } else if (header_.points() > kMostPoints ||
               (points_ > 0 && header_.points() != static_cast<std::size_t>(points_))) {
      Refuse(fmt::format("WIDTH {} times HEIGHT {} is not POINTS {}", header_.width, header_.height,
                         points_));
    }
    for (const char* name : {"x", "y", "z"}) {
      const int k = header_.Find(name);
      if (k < 0) {
        Refuse(fmt::format("there is no field {}", name));
        return;
      }
      const PcdField& field = header_.fields[k];
      if (field.type != 'F' || field.size < 4 || field.count != 1) {
        Refuse(fmt::format("field {} is not one float or double", name));
        return;
      }
    }
  }

  void Refuse(const std::string& why) {
    if (header_.error.empty()) {
      header_.error = fmt::format("line {}: {}", header_.lines, why);
    }
  }

  std::string_view bytes_;
  PcdHeader header_;
  int points_ = 0;
  bool done_ = false;
};

}  // namespace

std::size_t PcdHeader::point_bytes() const {
  std::size_t bytes = 0;
  for (const PcdField& field : fields) {
    bytes += static_cast<std::size_t>(field.size) * static_cast<std::size_t>(field.count);
  }
  return bytes;
}

int PcdHeader::Find(std::string_view name) const {
  for (std::size_t k = 0; k < fields.size(); ++k) {
    if (fields[k].name == name) {
      return static_cast<int>(k);
    }
  }
  return -1;
}

PcdHeader ParsePcdHeader(std::string_view bytes) { return HeaderParser(bytes).Parse(); }

}  // namespace pipewright::hil
