// SPDX-License-Identifier: MIT
#include "hil/cli/qp_sizes_inl.h"

namespace pipewright::hil {

void AddQpSizes20(QpSizes& sizes) {
  sizes.push_back(std::make_unique<SizedQpOf<20, 104>>());
  sizes.push_back(std::make_unique<SizedQpOf<20, 256>>());
}

}  // namespace pipewright::hil
