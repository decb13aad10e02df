// SPDX-License-Identifier: MIT
// Scenarios, and conditions that are laid over them.
#include <string_view>

#include "hil/world/scenario.h"
#include "tests/fuzz/require.h"

namespace pipewright::test {
namespace {

/// A mesh may lie anywhere, and what reads it is Assimp: no path may lead out of the folder that is
/// not there.
bool MayReadAFile(std::string_view toml) {
  return toml.find("mesh") != std::string_view::npos && toml.find('/') != std::string_view::npos;
}

}  // namespace
}  // namespace pipewright::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace pipewright;
  const std::string_view toml(reinterpret_cast<const char*>(bytes), size);
  if (test::MayReadAFile(toml)) {
    return -1;
  }
  const hil::ScenarioResult result = hil::ParseScenario(toml, "input", "no such folder");
  test::Require(result.scenario.has_value() == result.errors.empty(), "a scenario, or errors");
  if (result.scenario) {
    for (const BoxRegion& region : {result.scenario->workspace, result.scenario->map}) {
      const VoxelRange voxels = VoxelsOf(region);
      for (std::size_t i = 0; i < 3; ++i) {
        test::Require(voxels.lo[i] <= voxels.hi[i] && voxels.hi[i] - voxels.lo[i] <= 201,
                      "a region has voxels, and not too many");
      }
    }
  }
  hil::Conditions conditions;
  static_cast<void>(hil::LayOver(toml, "input", conditions));
  return 0;
}
