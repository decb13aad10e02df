// SPDX-License-Identifier: MIT
#include "hil/cli/memory_figures.h"

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

#include "platform/robot/uf7.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

std::int64_t HeapInUse() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<std::int64_t>(info.uordblks + info.hblkhd);
}

/// Makes one, and looks at what it takes beside its own size.
template <typename Task, typename... Arguments>
MemoryPart Measured(std::string name, std::string capacity, const Arguments&... arguments) {
  struct alignas(Task) Room {
    std::byte bytes[sizeof(Task)];
  };
  const auto room = std::make_unique<Room>();
  const std::int64_t before = HeapInUse();
  auto* const task = new (room->bytes) Task(arguments...);
  const std::int64_t taken = HeapInUse() - before;
  task->~Task();
  return {std::move(name), std::move(capacity), sizeof(Task), taken};
}

template <typename Value>
MemoryPart Exchange(std::string name, std::string capacity, std::int64_t heap_of_one) {
  return {std::move(name), std::move(capacity), sizeof(Latest<Value>), 3 * heap_of_one};
}

}  // namespace

std::vector<MemoryPart> MemoryParts(const RobotProgramConfig& config) {
  const MapConfig& map = config.mapping.map;
  const VoxelGrid grid(map);
  const DistanceField field(map);
  const std::int64_t grid_bytes = grid.MemoryBytes();
  const std::int64_t field_bytes = field.MemoryBytes();
  MemoryPart mapping =
      Measured<MappingTask>("mapping task", fmt::format("{} points a frame", Cloud::kMaxPoints),
                            config.mapping, TracerUf7());
  mapping.in_place -= static_cast<std::int64_t>(sizeof(VoxelGrid) + sizeof(DistanceField));
  mapping.heap = std::max<std::int64_t>(mapping.heap - grid_bytes - field_bytes, 0);
  return {
      Measured<ControlTask>("control task", "rows, QPs, drivers, envelope", config.control,
                            TracerUf7()),
      std::move(mapping),
      {"  its map", fmt::format("{} bricks of 512 voxels", map.brick_capacity), sizeof(VoxelGrid),
       grid_bytes},
      {"  its distance field", fmt::format("{} voxels", grid.voxel_count()), sizeof(DistanceField),
       field_bytes},
      Measured<PlanningTask>("planning task", "views, gains, motions, mission", config.mission,
                             map),
      Exchange<Surrounding>("mapping to control", "3 scenes, 3 distance fields", field_bytes),
      Exchange<MapSnapshot>("mapping to planning", "3 maps, 3 fields, 3 scenes",
                            grid_bytes + field_bytes),
      Exchange<Goal>("planning to control",
                     fmt::format("3 goals of {} waypoints", Goal::kMaxWaypoints), 0),
      Exchange<ResidualVoxels>("planning to mapping", "3 lists of 65536 voxels", 0),
      Exchange<StateHistory>("control to mapping", "3 histories of states", 0),
      Exchange<ControlReport>("control to planning", "3 reports", 0),
      {"control's own history", "states", sizeof(StateHistory), 0},
      {"frames to send", "2 batches", 2 * sizeof(TxBatch), 0},
  };
}

Json MemoryJson(const std::string& scenario, const RobotProgramConfig& config,
                const std::vector<MemoryPart>& parts) {
  Json rows = Json::array();
  std::int64_t total = 0;
  for (const MemoryPart& part : parts) {
    const std::size_t begin = part.name.find_first_not_of(' ');
    rows.push_back({{"part", part.name.substr(begin)},
                    {"capacity", part.capacity},
                    {"in_place_bytes", part.in_place},
                    {"heap_bytes", part.heap}});
    total += part.in_place + part.heap;
  }
  return {{"scenario", scenario},
          {"parts", rows},
          {"total_bytes", total},
          {"map",
           {{"bricks", config.mapping.map.brick_capacity},
            {"bytes_per_voxel_of_a_brick", VoxelGrid::kBytesPerVoxel}}}};
}

std::string MemoryTable(const Json& figures) {
  std::string table =
      fmt::format("{:<22} {:<34} {:>12} {:>12}\n", "part", "room for", "in place", "heap at start");
  for (const Json& row : figures["parts"]) {
    table += fmt::format("{:<22} {:<34} {:>12} {:>12}\n", row["part"].get<std::string>(),
                         row["capacity"].get<std::string>(), row["in_place_bytes"].get<int>(),
                         row["heap_bytes"].get<std::int64_t>());
  }
  return table + fmt::format("total {} bytes; a voxel of a brick takes {} bytes of the map\n",
                             figures["total_bytes"].get<std::int64_t>(),
                             figures["map"]["bytes_per_voxel_of_a_brick"].get<double>());
}

}  // namespace pipewright::hil
