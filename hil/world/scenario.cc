// SPDX-License-Identifier: MIT
#include "hil/world/scenario.h"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <set>

#include "embedded/Pipes1Toml.h"
#include "embedded/Pipes2Toml.h"
#include "embedded/Pipes3Toml.h"
#include "hil/world/toml_table.h"

namespace pipewright::hil {
namespace {

constexpr double kFar_m = 100;  // the world: coordinates beyond are a slip of the pen
constexpr double kTurn_rad = 4 * std::numbers::pi;
constexpr double kMaxSide_m = 10;     // of the workspace and the map
constexpr double kMapMargin_m = 0.5;  // around the workspace
constexpr double kStartRoom_m = 0.6;  // around the start: half a base, and room to turn

Matrix3d FromRpy(const Vector3d& rpy_rad) {
  return (Eigen::AngleAxisd(rpy_rad.z(), Vector3d::UnitZ()) *
          Eigen::AngleAxisd(rpy_rad.y(), Vector3d::UnitY()) *
          Eigen::AngleAxisd(rpy_rad.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

Isometry3d Pose(const Matrix3d& R_WG, const Vector3d& p_WG) {
  Isometry3d X_WG = Isometry3d::Identity();
  X_WG.linear() = R_WG;
  X_WG.translation() = p_WG;
  return X_WG;
}

/// A rotation whose third column is along n.
Matrix3d Upright(const Vector3d& n) {
  return Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), n).toRotationMatrix();
}

Vector3d Rpy(TomlTable& table) {
  return table.Vector("rpy_rad", -kTurn_rad, kTurn_rad, Vector3d::Zero());
}

BoxRegion ReadRegion(TomlTable& table, std::string_view min, std::string_view max) {
  BoxRegion region{table.Vector(min, -kFar_m, kFar_m), table.Vector(max, -kFar_m, kFar_m)};
  const Vector3d size = region.max_m - region.min_m;
  if (!(size.array() >= kVoxelWidth_m).all()) {
    table.Error(max, "must be greater than " + std::string(min) + " by a voxel (0.05 m) at least");
  } else if (!(size.array() <= kMaxSide_m).all()) {
    table.Error(max, "the box must not be longer than 10 m");
  }
  table.Finish();
  return region;
}

void ReadStart(TomlTable& table, StartPose& start) {
  start.where = table.Where();
  start.x_m = table.Number("x_m", -kFar_m, kFar_m);
  start.y_m = table.Number("y_m", -kFar_m, kFar_m);
  start.yaw_rad = table.Number("yaw_rad", -kTurn_rad, kTurn_rad);
  if (table.Has("joints_rad")) {
    start.joints_rad = table.Numbers("joints_rad", 7, -kTurn_rad, kTurn_rad);
  }
  start.clearance_m = table.Number("clearance_m", 0, 2, start.clearance_m);
  table.Finish();
}

/// W with a margin around it, and wide enough for a robot at the start.
BoxRegion DefaultMap(const BoxRegion& workspace, const StartPose& start) {
  const Vector3d start_m(start.x_m, start.y_m, workspace.min_m.z());
  const Vector3d margin = Vector3d::Constant(kMapMargin_m);
  const Vector3d room(kStartRoom_m, kStartRoom_m, 0);
  BoxRegion map{(workspace.min_m - margin).cwiseMin(start_m - room),
                (workspace.max_m + margin).cwiseMax(start_m + room)};
  map.min_m.z() = std::min(-0.1, workspace.min_m.z());
  return map;
}

/// When workspace and start are known.
void ReadMap(TomlTable& root, Scenario& scenario) {
  const StartPose& start = scenario.start;
  if (auto table = root.Table("map", false)) {
    scenario.map = ReadRegion(*table, "lo_m", "hi_m");
    const BoxRegion& map = scenario.map;
    if ((map.min_m.array() > scenario.workspace.min_m.array()).any() ||
        (map.max_m.array() < scenario.workspace.max_m.array()).any()) {
      table->Error("lo_m", "the map must hold the whole workspace");
    } else if (start.x_m < map.min_m.x() || start.x_m > map.max_m.x() ||
               start.y_m < map.min_m.y() || start.y_m > map.max_m.y()) {
      table->Error("lo_m", "the map must hold the place where the robot starts");
    }
    return;
  }
  scenario.map = DefaultMap(scenario.workspace, start);
  if (!((scenario.map.max_m - scenario.map.min_m).array() <= kMaxSide_m).all()) {
    root.Error("start", "too far from the workspace: a map of both would be longer than 10 m");
  }
}

Solid Named(SolidKind kind, TomlTable& table) {
  Solid solid;
  solid.kind = kind;
  solid.name = table.Text("name");
  return solid;
}

Solid ReadPlane(TomlTable& table) {
  Solid solid = Named(SolidKind::kPlane, table);
  const Vector3d normal = table.Vector("normal", -1e3, 1e3);
  const double offset_m = table.Number("offset_m", -kFar_m, kFar_m);
  solid.ground = table.Bool("ground", false);
  if (normal.norm() < 1e-6) {
    table.Error("normal", "must not be zero");
    return solid;
  }
  const Vector3d n_W = normal.normalized();
  solid.X_WG = Pose(Upright(n_W), n_W * offset_m);
  return solid;
}

Solid ReadBox(TomlTable& table) {
  Solid solid = Named(SolidKind::kBox, table);
  const Vector3d center = table.Vector("center_m", -kFar_m, kFar_m);
  solid.shape = Shape::Box(table.Vector("size_m", 1e-4, 2 * kFar_m));
  solid.X_WG = Pose(FromRpy(Rpy(table)), center);
  return solid;
}

Solid ReadCylinder(TomlTable& table) {
  Solid solid = Named(SolidKind::kCylinder, table);
  const Vector3d from = table.Vector("from_m", -kFar_m, kFar_m);
  const Vector3d to = table.Vector("to_m", -kFar_m, kFar_m);
  const double radius_m = table.Number("radius_m", 1e-4, kFar_m);
  const double length_m = (to - from).norm();
  if (length_m < 1e-4) {
    table.Error("to_m", "must differ from from_m");
    return solid;
  }
  solid.shape = Shape::Cylinder(radius_m, length_m);
  solid.X_WG = Pose(Upright((to - from) / length_m), (from + to) / 2);
  return solid;
}

Solid ReadMesh(TomlTable& table, const std::string& directory) {
  Solid solid = Named(SolidKind::kMesh, table);
  const std::string file = table.Text("file");
  const double scale = table.Number("scale", 1e-6, 1e6, 1.0);
  const Vector3d position = table.Vector("position_m", -kFar_m, kFar_m, Vector3d::Zero());
  const Isometry3d X_WG = Pose(FromRpy(Rpy(table)), position);
  auto mesh = std::make_shared<Mesh>();
  std::string why;
  const std::filesystem::path path = std::filesystem::path(directory) / file;
  if (!file.empty() && !LoadMesh(path.string(), scale, X_WG, *mesh, why)) {
    table.Error("file", "cannot be read: " + why);
  }
  solid.mesh = mesh;
  return solid;
}

void ReadSolids(TomlTable& root, const std::string& directory, std::vector<Solid>& solids) {
  std::set<std::string> names;
  const auto read = [&](std::string_view key, auto read_one) {
    for (TomlTable& table : root.Tables(key)) {
      solids.push_back(read_one(table));
      if (!names.insert(solids.back().name).second) {
        table.Error("name", "is taken: names must be unique");
      }
      table.Finish();
    }
  };
  read("plane", ReadPlane);
  read("box", ReadBox);
  read("cylinder", ReadCylinder);
  read("mesh", [&](TomlTable& table) { return ReadMesh(table, directory); });
}

Scenario ReadScenario(TomlTable& root, const std::string& directory) {
  Scenario scenario;
  scenario.name = root.Text("name");
  scenario.description = root.Text("description", "");
  auto workspace = root.Table("workspace", true);
  auto start = root.Table("start", true);
  if (workspace) {
    scenario.workspace = ReadRegion(*workspace, "min_m", "max_m");
  }
  if (start) {
    ReadStart(*start, scenario.start);
  }
  if (workspace && start) {
    ReadMap(root, scenario);
  } else {
    root.Table("map", false);
  }
  ReadSolids(root, directory, scenario.solids);
  ReadConditions(root, scenario);
  root.Finish();
  return scenario;
}

}  // namespace

VoxelRange VoxelsOf(const BoxRegion& region) {
  // A bound within a nanometre of a voxel face is meant to be on it.
  constexpr double kSlack = 1e-6;
  VoxelRange range;
  for (int i = 0; i < 3; ++i) {
    range.lo[i] = static_cast<int>(std::floor(region.min_m[i] / kVoxelWidth_m + kSlack));
    range.hi[i] = static_cast<int>(std::ceil(region.max_m[i] / kVoxelWidth_m - kSlack)) - 1;
  }
  return range;
}

ScenarioResult ParseScenario(std::string_view toml, const std::string& origin,
                             const std::string& directory) {
  ScenarioResult result;
  ReadToml(toml, origin, result.errors, [&](TomlTable& root) {
    Scenario scenario = ReadScenario(root, directory);
    if (result.errors.empty()) {
      result.scenario = std::move(scenario);
    }
  });
  return result;
}

ScenarioResult LoadScenario(const std::string& name_or_file) {
  std::vector<std::string> errors;
  const auto source = FindToml(name_or_file, ShippedScenarios(), "a shipped scenario", errors);
  return source ? ParseScenario(source->text, name_or_file, source->directory)
                : ScenarioResult{{}, errors};
}

const std::vector<ShippedToml>& ShippedScenarios() {
  static const std::vector<ShippedToml> kShipped = {{"pipes1", embedded::Pipes1Toml()},
                                                    {"pipes2", embedded::Pipes2Toml()},
                                                    {"pipes3", embedded::Pipes3Toml()}};
  return kShipped;
}

}  // namespace pipewright::hil
