// SPDX-License-Identifier: MIT
#include "hil/scans/scan_file.h"

#include <fmt/format.h>

#include <string>

#include "hil/scans/file_bytes.h"

namespace pipewright::hil {
namespace {

namespace fs = std::filesystem;

template <typename Content>
FileResult<Content> Finish(const fs::path& path, FileBytes& from, Content content) {
  from.TakeEnd();
  if (!from.good()) {
    return {std::nullopt, fmt::format("{}: {}", path.string(), from.error())};
  }
  return {std::move(content), ""};
}

std::string Name(const char* thing, int number, const char* field) {
  return fmt::format("{} {}: {}", thing, number, field);
}

float TakePositive(FileBytes& from, const std::string& name) {
  const float value = from.TakeFloat(name);
  if (from.good() && !(value > 0)) {
    from.Refuse(fmt::format("{} is {}, not above 0", name, value));
  }
  return value;
}

// What a person meant who wrote 0.05 and had to store a float.
double Decimal(float value) { return std::stod(fmt::format("{}", value)); }

}  // namespace

FileResult<ScanSet> ReadScans(const fs::path& path) {
  FileBytes from(path);
  from.TakeMagic("MPC1");
  const int scans = from.TakeCount("the number of scans", 1, FileBytes::kAnyCount);
  from.TakeCount("the image's width", 0, FileBytes::kAnyCount);
  from.TakeCount("the image's height", 0, FileBytes::kAnyCount);
  ScanSet set;
  set.width_m = Decimal(TakePositive(from, "the voxels' width"));
  set.max_range_m = from.TakeFloat("the range limit");
  from.TakeFloat("fx");
  from.TakeFloat("fy");
  for (int k = 0; from.good() && k < scans; ++k) {
    TakenScan scan;
    scan.origin_W = from.TakeVector(Name("scan", k, "its origin"));
    for (int row = 0; row < 3; ++row) {
      from.TakeVector(Name("scan", k, "its rotation"));  // the points are in W already
    }
    const int points =
        from.TakeCount(Name("scan", k, "its number of points"), 0, FileBytes::kAnyCount);
    scan.points_W = from.TakePoints(Name("scan", k, "its points"), points);
    set.scans.push_back(std::move(scan));
  }
  return Finish(path, from, std::move(set));
}

FileResult<ViewSet> ReadViews(const fs::path& path) {
  FileBytes from(path);
  from.TakeMagic("MPV1");
  const int views = from.TakeCount("the number of views", 1, FileBytes::kAnyCount);
  const int visual = from.TakeCount("the number of visual rays", 0, FileBytes::kAnyCount);
  const int coverage = from.TakeCount("the number of coverage rays", 0, FileBytes::kAnyCount);
  ViewSet set;
  set.visual_range_m = TakePositive(from, "the visual range");
  set.coverage_range_m = TakePositive(from, "the coverage range");
  for (int k = 0; from.good() && k < views; ++k) {
    GainView view;
    view.p_W = from.TakeVector(Name("view", k, "its place"));
    from.TakeVector(Name("view", k, "its axis"));
    view.visual_W = from.TakePoints(Name("view", k, "its visual rays"), visual);
    view.coverage_W = from.TakePoints(Name("view", k, "its coverage rays"), coverage);
    set.views.push_back(std::move(view));
  }
  return Finish(path, from, std::move(set));
}

FileResult<RaySetFile> ReadRays(const fs::path& path) {
  FileBytes from(path);
  from.TakeMagic("MPR1");
  const int rays = from.TakeCount("the number of rays", 1, FileBytes::kAnyCount);
  RaySetFile set;
  set.max_range_m = from.TakeFloat("the range limit");
  for (int k = 0; from.good() && k < rays; ++k) {
    QueryRay ray;
    ray.origin_W = from.TakeVector(Name("ray", k, "its origin"));
    ray.direction_W = from.TakeVector(Name("ray", k, "its direction"));
    set.rays.push_back(ray);
  }
  return Finish(path, from, std::move(set));
}

}  // namespace pipewright::hil
