// SPDX-License-Identifier: MIT
#include "hil/cli/qp_sizes_inl.h"

namespace pipewright::hil {

void AddQpSizes5(QpSizes& sizes) {
  sizes.push_back(std::make_unique<SizedQpOf<5, 40>>());
  sizes.push_back(std::make_unique<SizedQpOf<5, 256>>());
}

}  // namespace pipewright::hil
