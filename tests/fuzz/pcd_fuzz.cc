// SPDX-License-Identifier: MIT
// Point clouds: PCD in text, binary and packed.
#include "hil/pcd/pcd.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace pipewright;
  const test::MemoryFile file(bytes, size);
  const hil::PcdResult result = hil::ReadPcd(file.path());
  test::Require(result.cloud.has_value() == result.error.empty(), "a cloud, or an error");
  if (result.cloud) {
    test::Require(result.cloud->points.size() == static_cast<std::size_t>(result.cloud->width) *
                                                     static_cast<std::size_t>(result.cloud->height),
                  "as many points as width times height");
  }
  return 0;
}
