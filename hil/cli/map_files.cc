// SPDX-License-Identifier: MIT
#include "hil/cli/map_files.h"

#include <fmt/format.h>

#include <fstream>

namespace pipewright::hil {
namespace {

namespace fs = std::filesystem;

class BytesOut {
 public:
  explicit BytesOut(const char* magic) { Magic(magic); }

  void Magic(const char* magic) { bytes_.append(magic, 4); }
  template <typename T>
  void Put(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void Key(const VoxelIndex& v) {
    for (const int i : {v.x, v.y, v.z}) {
      Put(static_cast<std::uint16_t>(i + 32768));
    }
  }
  std::string WriteTo(const fs::path& path) const {
    std::ofstream file(path, std::ios::binary);
    file.write(bytes_.data(), static_cast<std::streamsize>(bytes_.size()));
    file.close();
    return file ? "" : fmt::format("{}: cannot be written", path.string());
  }

 private:
  std::string bytes_;
};

void PutHits(const RayAnswers& answers, BytesOut& out) {
  out.Put(static_cast<std::uint32_t>(answers.hits.size()));
  for (const RayHit& hit : answers.hits) {
    out.Put(static_cast<std::uint16_t>(hit.hit ? 1 : 0));
    out.Key(hit.end);
  }
}

}  // namespace

std::string WriteMapDump(const MapRun& run, const fs::path& path) {
  const VoxelGrid& grid = *run.grid;
  BytesOut out("MPM1");
  const MapCounts& counts = grid.counts();
  const std::int64_t outside = run.window ? run.window->known_outside() : 0;
  out.Put(static_cast<std::uint32_t>(counts.free + counts.occupied + outside));
  for (int i = 0; i < grid.voxel_count(); ++i) {
    if (grid.KnownAt(i)) {
      const VoxelIndex v = grid.VoxelAt(i);
      out.Key(v);
      out.Put(grid.LogOdds(v));
    }
  }
  if (run.window) {
    for (const auto& [key, brick] : run.window->left()) {
      for (int i = 0; i < BrickVoxels::kVoxels; ++i) {
        if (brick.known[i]) {
          out.Key(brick.VoxelAt(i));
          out.Put(brick.log_odds[i]);
        }
      }
    }
  }
  return out.WriteTo(path);
}

std::string WriteRayHits(const MapRun& run, const fs::path& path) {
  BytesOut out("MPH1");
  PutHits(run.stop_at_unknown, out);
  out.Magic("MPH1");
  PutHits(run.ignore_unknown, out);
  return out.WriteTo(path);
}

std::string WriteViewCounts(const MapRun& run, const fs::path& path) {
  BytesOut out("MPG1");
  out.Put(static_cast<std::uint32_t>(run.views.size()));
  for (const ViewCounts& view : run.views) {
    for (const std::uint32_t count :
         {view.unknown, view.visual_hits, view.uncovered_hits, view.coverage_hits}) {
      out.Put(count);
    }
  }
  return out.WriteTo(path);
}

}  // namespace pipewright::hil
