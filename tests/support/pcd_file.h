// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace pipewright::test {

/// A PCD header of fields x, y, z and DATA `data`.
inline std::string PcdHeaderText(int width, int height, const std::string& data) {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " +
         std::to_string(width) + "\nHEIGHT " + std::to_string(height) +
         "\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + std::to_string(width * height) + "\nDATA " + data +
         "\n";
}

inline std::string Bytes(const void* from, std::size_t size) {
  return {static_cast<const char*>(from), size};
}

/// A whole binary file; height 1 is not organised.
inline std::string BinaryPcd(const std::vector<Eigen::Vector3f>& points, int height = 1) {
  std::string file = PcdHeaderText(static_cast<int>(points.size()) / height, height, "binary");
  for (const Eigen::Vector3f& p : points) {
    file += Bytes(p.data(), 3 * sizeof(float));
  }
  return file;
}

/// LZF that packs nothing: runs of literals. Valid all the same.
inline std::string LiteralLzf(const std::string& bytes) {
  std::string packed;
  for (std::size_t at = 0; at < bytes.size(); at += 32) {
    const std::string run = bytes.substr(at, 32);
    packed += static_cast<char>(run.size() - 1);
    packed += run;
  }
  return packed;
}

inline std::string CompressedPcd(const std::vector<Eigen::Vector3f>& points) {
  std::string fields;
  for (int axis = 0; axis < 3; ++axis) {
    for (const Eigen::Vector3f& p : points) {
      fields += Bytes(&p[axis], sizeof(float));
    }
  }
  const std::string packed = LiteralLzf(fields);
  const std::uint32_t sizes[2] = {static_cast<std::uint32_t>(packed.size()),
                                  static_cast<std::uint32_t>(fields.size())};
  return PcdHeaderText(static_cast<int>(points.size()), 1, "binary_compressed") +
         Bytes(sizes, sizeof sizes) + packed;
}

}  // namespace pipewright::test
