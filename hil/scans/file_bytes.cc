// SPDX-License-Identifier: MIT
#include "hil/scans/file_bytes.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>

namespace pipewright::hil {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "numbers are taken as they lie");
static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));

FileBytes::FileBytes(const fs::path& path) {
  std::error_code failed;
  const fs::file_status status = fs::status(path, failed);
  if (!fs::exists(status)) {
    error_ = "no such file";
  } else if (!fs::is_regular_file(status)) {
    error_ = "is not a file";  // a pipe or device may never end
  } else {
    file_.open(path, std::ios::binary);
    size_ = fs::file_size(path, failed);
    error_ = failed || !file_ ? "cannot be read" : "";
  }
}

void FileBytes::Refuse(std::string why) {
  if (good()) {
    error_ = std::move(why);
  }
}

void FileBytes::TakeMagic(const char (&magic)[5]) {
  char found[4] = {};
  Take(found, sizeof found, "its first four bytes");
  if (good() && std::memcmp(found, magic, sizeof found) != 0) {
    Refuse(fmt::format("is not {}: its first four bytes are others", magic));
  }
}

int FileBytes::TakeCount(const std::string& name, int least, int most) {
  std::uint32_t value = 0;
  const std::uintmax_t from = at_;
  Take(&value, sizeof value, name);
  if (good() &&
      (value < static_cast<std::uint32_t>(least) || value > static_cast<std::uint32_t>(most))) {
    Refuse(fmt::format("{} is {} (byte {}), not from {} to {}", name, value, from, least, most));
  }
  return good() ? static_cast<int>(value) : 0;
}

float FileBytes::TakeFloat(const std::string& name) {
  float value = 0;
  const std::uintmax_t from = at_;
  Take(&value, sizeof value, name);
  if (good() && !std::isfinite(value)) {
    Refuse(fmt::format("{} is not a number (byte {})", name, from));
  }
  return good() ? value : 0;
}

Eigen::Vector3f FileBytes::TakeVector(const std::string& name) {
  Eigen::Vector3f v;
  for (float& coordinate : v) {
    coordinate = TakeFloat(name);
  }
  return v;
}

std::vector<Eigen::Vector3f> FileBytes::TakePoints(const std::string& name, int count) {
  std::vector<Eigen::Vector3f> points;
  if (good() && static_cast<std::uintmax_t>(count) > (size_ - at_) / sizeof(Eigen::Vector3f)) {
    CutShort(name);  // before any memory is taken for it
  }
  if (good() && count > 0) {
    points.resize(static_cast<std::size_t>(count));
    Take(points.data(), points.size() * sizeof(Eigen::Vector3f), name);
  }
  return points;
}

void FileBytes::TakeEnd() {
  if (good() && at_ != size_) {
    Refuse(fmt::format("has {} bytes too many, from byte {} on", size_ - at_, at_));
  }
}

void FileBytes::Take(void* to, std::uintmax_t bytes, const std::string& name) {
  if (!good()) {
    return;
  }
  if (bytes > size_ - at_ ||
      !file_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes))) {
    CutShort(name);
  }
  at_ += bytes;
}

void FileBytes::CutShort(const std::string& name) {
  Refuse(fmt::format("is cut short at byte {}: {} begins at byte {} and does not end", size_, name,
                     at_));
}

}  // namespace pipewright::hil
