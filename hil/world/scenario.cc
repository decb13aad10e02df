// SPDX-License-Identifier: MIT
#include "hil/world/scenario.h"

#include <filesystem>
#include <numbers>
#include <set>

#include "embedded/Pipes1Toml.h"
#include "embedded/Pipes2Toml.h"
#include "embedded/Pipes3Toml.h"
#include "platform/toml/toml_table.h"

namespace pipewright::hil {
namespace {

constexpr double kFar_m = 100;  // the world: coordinates beyond are a slip of the pen
constexpr double kTurn_rad = 4 * std::numbers::pi;

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
  ReadSite(root, scenario);
  ReadSolids(root, directory, scenario.solids);
  ReadConditions(root, scenario);
  root.Finish();
  return scenario;
}

}  // namespace

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
