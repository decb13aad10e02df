// SPDX-License-Identifier: MIT
#include "hil/pcd/pcd.h"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>

#include "hil/pcd/lzf.h"
#include "hil/pcd/pcd_header.h"

namespace pipewright::hil {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "numbers are taken as they lie");

constexpr const char* kAxes[3] = {"x", "y", "z"};

float NumberAt(const char* at, int size) {
  if (size == sizeof(float)) {
    float value = 0;
    std::memcpy(&value, at, sizeof value);
    return value;
  }
  double value = 0;
  std::memcpy(&value, at, sizeof value);
  return static_cast<float>(value);
}

/// Points that lie one after the other, `stride` bytes each, or field after field.
std::string TakeBinary(const PcdHeader& header, std::string_view body, bool by_field,
                       PcdCloud& cloud) {
  const std::size_t points = header.points();
  const std::size_t stride = header.point_bytes();
  if (body.size() / stride < points) {
    return fmt::format("is cut short at byte {}: {} points of {} bytes begin at byte {}",
                       header.body + body.size(), points, stride, header.body);
  }
  cloud.points.resize(points);
  std::size_t offset = 0;
  for (const PcdField& field : header.fields) {
    const std::size_t bytes =
        static_cast<std::size_t>(field.size) * static_cast<std::size_t>(field.count);
    for (int axis = 0; axis < 3; ++axis) {
      if (field.name != kAxes[axis]) {
        continue;
      }
      const char* at = body.data() + (by_field ? offset * points : offset);
      for (std::size_t k = 0; k < points; ++k, at += by_field ? bytes : stride) {
        cloud.points[k][axis] = NumberAt(at, field.size);
      }
    }
    offset += bytes;
  }
  return "";
}

std::string TakeCompressed(const PcdHeader& header, std::string_view body, PcdCloud& cloud) {
  std::uint32_t sizes[2] = {0, 0};  // packed, unpacked
  if (body.size() < sizeof sizes) {
    return fmt::format("is cut short at byte {}: the packed size", header.body + body.size());
  }
  std::memcpy(sizes, body.data(), sizeof sizes);
  body.remove_prefix(sizeof sizes);
  const std::size_t start = header.body + sizeof sizes;
  if (sizes[0] > body.size()) {
    return fmt::format("is cut short at byte {}: {} packed bytes begin at byte {}",
                       start + body.size(), sizes[0], start);
  }
  const std::size_t expected = header.points() * header.point_bytes();
  if (sizes[1] != expected || sizes[1] / kLzfLargestGrowth > sizes[0]) {
    return fmt::format("byte {}: {} bytes from {} packed ones cannot be the {} of {} points",
                       header.body, sizes[1], sizes[0], expected, header.points());
  }
  std::vector<unsigned char> unpacked(sizes[1]);
  const auto* packed = reinterpret_cast<const unsigned char*>(body.data());
  if (const auto wrong = UnpackLzf({packed, sizes[0]}, unpacked)) {
    return fmt::format("byte {}: the packed points make no sense from here on", start + *wrong);
  }
  return TakeBinary(header, {reinterpret_cast<const char*>(unpacked.data()), unpacked.size()},
                    /*by_field=*/true, cloud);
}

/// The next word of a line, or an empty one.
std::string_view NextWord(std::string_view& line) {
  constexpr std::string_view kBlank = " \t\r";
  line.remove_prefix(std::min(line.find_first_not_of(kBlank), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kBlank));
  line.remove_prefix(word.size());
  return word;
}

std::string TakeLine(const PcdHeader& header, std::string_view line, Eigen::Vector3f& point) {
  for (const PcdField& field : header.fields) {
    for (int value = 0; value < field.count; ++value) {
      const std::string_view word = NextWord(line);
      if (word.empty()) {
        return fmt::format("field {} is missing", field.name);
      }
      for (int axis = 0; axis < 3; ++axis) {
        if (field.name != kAxes[axis]) {
          continue;
        }
        double number = 0;
        const char* const end = word.data() + word.size();
        const auto [at, error] = std::from_chars(word.data(), end, number);
        if (error != std::errc() || at != end) {
          return fmt::format("field {}: '{}' is no number", field.name, word.substr(0, 30));
        }
        point[axis] = static_cast<float>(number);
      }
    }
  }
  return NextWord(line).empty() ? "" : "has more values than fields";
}

std::string TakeAscii(const PcdHeader& header, std::string_view body, PcdCloud& cloud) {
  const std::size_t points = header.points();
  int number = header.lines;
  while (cloud.points.size() < points) {
    ++number;
    if (body.empty()) {
      return fmt::format("line {}: the file ends after {} of {} points", number,
                         cloud.points.size(), points);
    }
    const std::size_t end = std::min(body.find('\n'), body.size());
    Eigen::Vector3f point;
    const std::string error = TakeLine(header, body.substr(0, end), point);
    if (!error.empty()) {
      return fmt::format("line {}: {}", number, error);
    }
    cloud.points.push_back(point);
    body.remove_prefix(std::min(end + 1, body.size()));
  }
  return "";
}

std::string Parse(std::string_view bytes, PcdCloud& cloud) {
  const PcdHeader header = ParsePcdHeader(bytes);
  if (!header.error.empty()) {
    return header.error;
  }
  cloud.width = header.width;
  cloud.height = header.height;
  const std::string_view body = bytes.substr(header.body);
  switch (header.data) {
    case PcdData::kAscii:
      return TakeAscii(header, body, cloud);
    case PcdData::kBinary:
      return TakeBinary(header, body, /*by_field=*/false, cloud);
    case PcdData::kCompressed:
      return TakeCompressed(header, body, cloud);
  }
  return "";
}

/// The whole file, or why not.
std::string Slurp(const fs::path& path, std::string& bytes) {
  std::error_code failed;
  const fs::file_status status = fs::status(path, failed);
  if (!fs::exists(status)) {
    return "no such file";
  }
  if (!fs::is_regular_file(status)) {
    return "is not a file";  // a pipe or device may never end
  }
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf())) {
    return "cannot be read, or is empty";
  }
  bytes = std::move(text).str();
  return "";
}

}  // namespace

PcdResult ReadPcd(const fs::path& path) {
  std::string bytes;
  PcdCloud cloud;
  std::string error = Slurp(path, bytes);
  if (error.empty()) {
    error = Parse(bytes, cloud);
  }
  if (!error.empty()) {
    return {std::nullopt, fmt::format("{}: {}", path.string(), error)};
  }
  return {std::move(cloud), ""};
}

}  // namespace pipewright::hil
