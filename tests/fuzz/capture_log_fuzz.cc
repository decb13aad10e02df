// SPDX-License-Identifier: MIT
// CAN logs that are binary: pcap and pcapng, and any log packed by gz or zstd.
#include "tests/fuzz/read_whole_log.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  pipewright::test::ReadWholeLog(bytes, size, /*deltas=*/false);
  return 0;
}
