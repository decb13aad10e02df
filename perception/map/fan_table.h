// SPDX-License-Identifier: MIT
#pragma once

#include "perception/map/fan_kernels.h"

namespace pipewright::fan {

/// The kernels of fan_kernels.h for one instruction set.
struct Table {
  decltype(&Clip) clip;
  decltype(&Cells) cells;
  decltype(&Mark) mark;
  decltype(&Trace) trace;
  decltype(&Cast) cast;
  decltype(&Gather) gather;
  decltype(&FindBlocked) find_blocked;
};

namespace baseline {
extern const Table kTable;
}
namespace avx2 {
extern const Table kTable;  // only where PIPEWRIGHT_FAN_AVX2 is defined
}

}  // namespace pipewright::fan
