// SPDX-License-Identifier: MIT
// Maps: OctoMap's .bt and .ot.
#include "perception/octomap/octomap_file.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace pipewright;
  const test::MemoryFile file(bytes, size);
  constexpr MapConfig kBox{.lo = {-8, -8, -8},
                           .hi = {7, 7, 7},
                           .workspace_lo = {-8, -8, -8},
                           .workspace_hi = {7, 7, 7},
                           .brick_capacity = 6};  // of 8: that it is full is met, too
  VoxelGrid grid(kBox);
  const Result<OctomapFileStats> read = ReadOctomap(file.path(), &grid);
  const MapCounts& counts = grid.counts();
  test::Require(counts.free + counts.occupied + counts.unknown + counts.residual == counts.total,
                "counts add up");
  test::Require(
      read.ok() ? counts.free + counts.occupied <= read->restored : counts.unknown == counts.total,
      "the map holds what was restored; nothing of a file that makes no sense");
  return 0;
}
