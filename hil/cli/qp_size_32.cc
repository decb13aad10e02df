// SPDX-License-Identifier: MIT
#include "hil/cli/qp_sizes_inl.h"

namespace pipewright::hil {

void AddQpSizes32(QpSizes& sizes) { sizes.push_back(std::make_unique<SizedQpOf<32, 256>>()); }

}  // namespace pipewright::hil
