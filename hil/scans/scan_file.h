// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pipewright::hil {

/// Point clouds with the place they were taken from, and two kinds of questions to ask of a map
/// made of them. Files are little-endian; f32 unless noted; u32 counts; everything in W, metres.
///
///   scans   'MPC1', n, W, H, width, max_range, fx, fy;
///           n x { origin[3], R_WS[9] row-major, npts, xyz[npts][3] }
///   views   'MPV1', n, nvis, ncov, visual_range, coverage_range;
///           n x { p[3], axis[3], visual directions[nvis][3], coverage directions[ncov][3] }
///   rays    'MPR1', n, max_range; n x { origin[3], direction[3] }
///
/// A reader's result is whole and as documented, or nothing and an error in words that names the
/// file and the byte. Coordinates of points need not be numbers; all else is.
struct TakenScan {
  Eigen::Vector3f origin_W = Eigen::Vector3f::Zero();
  std::vector<Eigen::Vector3f> points_W;
};

struct ScanSet {
  double width_m = 0;      ///< of a voxel: the shortest decimal that gives the file's float
  double max_range_m = 0;  ///< negative: none
  std::vector<TakenScan> scans;
};

struct GainView {
  Eigen::Vector3f p_W = Eigen::Vector3f::Zero();
  std::vector<Eigen::Vector3f> visual_W;  ///< unit directions
  std::vector<Eigen::Vector3f> coverage_W;
};

struct ViewSet {
  float visual_range_m = 0;
  float coverage_range_m = 0;
  std::vector<GainView> views;
};

struct QueryRay {
  Eigen::Vector3f origin_W = Eigen::Vector3f::Zero();
  Eigen::Vector3f direction_W = Eigen::Vector3f::Zero();
};

struct RaySetFile {
  float max_range_m = 0;  ///< <= 0: none
  std::vector<QueryRay> rays;
};

template <typename Content>
struct FileResult {
  std::optional<Content> content;
  std::string error;
};

FileResult<ScanSet> ReadScans(const std::filesystem::path& path);
FileResult<ViewSet> ReadViews(const std::filesystem::path& path);
FileResult<RaySetFile> ReadRays(const std::filesystem::path& path);

}  // namespace pipewright::hil
