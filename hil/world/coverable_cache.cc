// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <type_traits>

#include "hil/world/coverable.h"

namespace pipewright::hil {
namespace {

/// Raised when the sampling or the file's layout changes.
constexpr std::uint64_t kVersion = 1;

/// FNV-1a, 64 bits (Fowler, Noll, Vo).
class Hash {
 public:
  void Bytes(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) {
      value_ = (value_ ^ bytes[i]) * 0x100000001B3U;
    }
  }
  template <typename T>
  requires std::is_arithmetic_v<T>
  void Add(T value) { Bytes(&value, sizeof value); }
  void Add(const Vector3d& v) { Bytes(v.data(), 3 * sizeof(double)); }
  void Add(const Isometry3d& X) { Bytes(X.data(), 16 * sizeof(double)); }
  void Add(const Shape& shape) {
    Add(static_cast<int>(shape.kind));
    Add(shape.size_m);
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325U;
};

void AddRobot(const RobotBodies& robot, Hash& hash) {
  for (const Body& body : robot.bodies) {
    hash.Add(body.link);
    hash.Add(body.group);
    hash.Add(body.shape);
    hash.Add(body.X_LG);
  }
  for (const auto& [a, b] : robot.adjacent_groups) {
    hash.Add(a);
    hash.Add(b);
  }
  // The kinematics, by what they do to a few postures.
  RobotBodies::Pose pose;
  std::vector<double> joints(robot.joint_min_rad.size());
  for (int k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < joints.size(); ++i) {
      hash.Add(robot.joint_min_rad[i]);
      hash.Add(robot.joint_max_rad[i]);
      joints[i] = 0.1 * k * static_cast<double>(i + 1);
    }
    robot.forward(0.3 * k, 0.2 * k, 0.7 * k, joints, pose);
    hash.Add(pose.p_WP);
    for (const Isometry3d& X_WL : pose.X_WL) {
      hash.Add(X_WL);
    }
  }
}

std::uint64_t KeyOf(const Scenario& scenario, const RobotBodies& robot, const CoverageProbe& probe,
                    const CoverableConfig& config) {
  Hash hash;
  hash.Add(kVersion);
  for (const Vector3d& v : {scenario.workspace.min_m, scenario.workspace.max_m, scenario.map.min_m,
                            scenario.map.max_m}) {
    hash.Add(v);
  }
  hash.Add(scenario.start.x_m);
  hash.Add(scenario.start.y_m);
  hash.Add(scenario.start.yaw_rad);
  for (const Solid& solid : scenario.solids) {
    hash.Add(static_cast<int>(solid.kind));
    hash.Add(solid.ground);
    hash.Add(solid.X_WG);
    hash.Add(solid.shape);
    if (solid.mesh) {
      for (const Mesh::Triangle& t : solid.mesh->triangles()) {
        for (const int corner : t) {
          hash.Add(solid.mesh->vertices()[corner]);
        }
      }
    }
  }
  AddRobot(robot, hash);
  hash.Add(probe.radius_m());
  hash.Add(static_cast<std::uint64_t>(probe.surface().samples.size()));
  hash.Add(config.min_configurations);
  hash.Add(config.max_configurations);
  hash.Add(config.saturated_after);
  hash.Add(config.seed);
  return hash.value();
}

/// Empty when the environment names no place.
std::filesystem::path CacheFile(std::uint64_t key) {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  std::filesystem::path folder;
  if (cache != nullptr && *cache != '\0') {
    folder = std::filesystem::path(cache) / "pipewright";
  } else if (home != nullptr && *home != '\0') {
    folder = std::filesystem::path(home) / ".cache" / "pipewright";
  } else {
    return {};
  }
  constexpr char kDigits[] = "0123456789abcdef";
  std::string name = "coverable-";
  for (int shift = 60; shift >= 0; shift -= 4) {
    name += kDigits[key >> shift & 15];
  }
  return folder / name;
}

/// The file: key, configurations, saturated, then a byte for each surface voxel, then a hash of it
/// all.
std::string Pack(std::uint64_t key, const CoverableSet& set) {
  const std::array<std::uint64_t, 3> head = {key, static_cast<std::uint64_t>(set.configurations),
                                             set.saturated ? 1U : 0U};
  std::string bytes(reinterpret_cast<const char*>(head.data()), sizeof head);
  bytes.append(reinterpret_cast<const char*>(set.coverable.data()), set.coverable.size());
  Hash hash;
  hash.Bytes(bytes.data(), bytes.size());
  const std::uint64_t sum = hash.value();
  bytes.append(reinterpret_cast<const char*>(&sum), sizeof sum);
  return bytes;
}

bool Read(const std::filesystem::path& path, std::uint64_t key, std::size_t voxels,
          CoverableSet& set) {
  std::ifstream file(path, std::ios::binary);
  const std::size_t head_size = 3 * sizeof(std::uint64_t);
  std::string bytes(head_size + voxels + sizeof(std::uint64_t), '\0');
  if (!file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) {
    return false;
  }
  std::array<std::uint64_t, 3> head{};
  std::memcpy(head.data(), bytes.data(), head_size);
  CoverableSet read;
  read.configurations = static_cast<int>(head[1]);
  read.saturated = head[2] != 0;
  read.coverable.assign(bytes.begin() + static_cast<std::ptrdiff_t>(head_size),
                        bytes.begin() + static_cast<std::ptrdiff_t>(head_size + voxels));
  if (Pack(key, read) != bytes) {
    return false;
  }
  for (const std::uint8_t covered : read.coverable) {
    read.count += covered;
  }
  read.from_cache = true;
  set = std::move(read);
  return true;
}

/// Through a file of this process's own, so that a reader never sees half of one.
void Write(const std::filesystem::path& path, const std::string& bytes) {
  std::error_code ignored;
  std::filesystem::create_directories(path.parent_path(), ignored);
  const std::filesystem::path part = path.string() + "." + std::to_string(getpid());
  std::ofstream file(part, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file) {
    std::filesystem::rename(part, path, ignored);
  } else {
    std::filesystem::remove(part, ignored);
  }
}

}  // namespace

CoverableSet CachedCoverable(const Scenario& scenario, const RobotBodies& robot,
                             const CoverageProbe& probe, const CoverableConfig& config) {
  const std::uint64_t key = KeyOf(scenario, robot, probe, config);
  const std::filesystem::path path = CacheFile(key);
  CoverableSet set;
  if (!path.empty() && Read(path, key, probe.surface().voxels.size(), set)) {
    return set;
  }
  set = ComputeCoverable(scenario, robot, probe, config);
  if (!path.empty()) {
    Write(path, Pack(key, set));
  }
  return set;
}

}  // namespace pipewright::hil
