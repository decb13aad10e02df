// SPDX-License-Identifier: MIT
#include "hil/cli/qp_sizes_inl.h"

namespace pipewright::hil {

void AddQpSizes10(QpSizes& sizes) {
  sizes.push_back(std::make_unique<SizedQpOf<10, 80>>());
  sizes.push_back(std::make_unique<SizedQpOf<10, 256>>());
}

}  // namespace pipewright::hil
