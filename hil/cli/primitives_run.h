// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "hil/pcd/pcd.h"
#include "perception/cloud/cluster_finder.h"
#include "perception/primitives/pipe_finder.h"
#include "perception/primitives/plane_finder.h"

namespace pipewright::hil {

struct PrimitivesOptions {
  std::string file;
  double sigma_m = 0;  ///< 0: the default of the cloud's kind
  double neighbour_m = 0.15;
  double range_m = 3;
  double radius_min_m = 0.02;
  double radius_max_m = 0.15;
  double length_min_m = 0.08;
  double reach_m = 0.05;              ///< of clusters
  std::optional<double> spacing_rad;  ///< the reach's growth per range; none: by the cloud's kind
  std::uint64_t seed = 1;
  bool json = false;
};

/// What was found in a cloud, in the file's frame.
struct PrimitivesRun {
  bool organised = false;  ///< taken as the image of a pinhole at the frame's origin
  int points = 0;          ///< of the file, with a reading
  int used = 0;            ///< after thinning
  double sigma_m = 0;
  std::vector<DetectedPlane> planes;
  std::vector<DetectedPipe> pipes;
  int unexplained = 0;  ///< points that are of no plane and no pipe
  double spacing_rad = 0;
  int clustered = 0;  ///< of those, after thinning
  std::vector<PointCluster> clusters;
  int clusters_left_out = 0;
};

/// Organised clouds that a pinhole at the origin could have seen as depth images, all others as
/// points in any order. What they leave unexplained is clustered.
PrimitivesRun RunPrimitives(const PcdCloud& cloud, const PrimitivesOptions& options);

nlohmann::ordered_json PrimitivesJson(const PrimitivesRun& run, const PrimitivesOptions& options);

/// The same for people: a line a primitive.
std::string PrimitivesTable(const PrimitivesRun& run, const PrimitivesOptions& options);

}  // namespace pipewright::hil
