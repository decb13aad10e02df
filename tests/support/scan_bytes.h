// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace pipewright::test {

using FileVector = std::vector<float>;  // three numbers

/// The bytes of scan, view and ray files, from what a reader must find in them.
class ScanBytes {
 public:
  explicit ScanBytes(const char* magic) { bytes_.append(magic, 4); }

  ScanBytes& Count(std::uint32_t value) { return Raw(&value, 4); }
  ScanBytes& Floats(const FileVector& values) { return Raw(values.data(), 4 * values.size()); }
  const std::string& str() const { return bytes_; }

 private:
  ScanBytes& Raw(const void* from, std::size_t bytes) {
    bytes_.append(static_cast<const char*>(from), bytes);
    return *this;
  }

  std::string bytes_;
};

struct ScanFrom {
  FileVector origin;
  FileVector points;
};

/// Scans of 0.05 m voxels.
inline std::string ScansFile(const std::vector<ScanFrom>& scans, float max_range_m = -1) {
  ScanBytes file("MPC1");
  file.Count(static_cast<std::uint32_t>(scans.size())).Count(160).Count(120);
  file.Floats({0.05F, max_range_m, 100, 100});
  for (const ScanFrom& scan : scans) {
    file.Floats(scan.origin).Floats({1, 0, 0, 0, 1, 0, 0, 0, 1});
    file.Count(static_cast<std::uint32_t>(scan.points.size() / 3)).Floats(scan.points);
  }
  return file.str();
}

/// All from one origin.
inline std::string ScansFile(const FileVector& origin, const std::vector<FileVector>& clouds,
                             float max_range_m = -1) {
  std::vector<ScanFrom> scans;
  for (const FileVector& points : clouds) {
    scans.push_back({origin, points});
  }
  return ScansFile(scans, max_range_m);
}

inline std::string ViewsFile(const FileVector& place, const FileVector& visual,
                             const FileVector& coverage) {
  ScanBytes file("MPV1");
  file.Count(1);
  file.Count(static_cast<std::uint32_t>(visual.size() / 3));
  file.Count(static_cast<std::uint32_t>(coverage.size() / 3));
  file.Floats({3.0F, 0.4F}).Floats(place).Floats({1, 0, 0}).Floats(visual).Floats(coverage);
  return file.str();
}

inline std::string RaysFile(float max_range_m, const std::vector<FileVector>& rays) {
  ScanBytes file("MPR1");
  file.Count(static_cast<std::uint32_t>(rays.size())).Floats({max_range_m});
  for (const FileVector& ray : rays) {
    file.Floats(ray);
  }
  return file.str();
}

}  // namespace pipewright::test
