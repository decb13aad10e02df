// SPDX-License-Identifier: MIT
// Compiled with AVX2 where the target is x86-64; empty elsewhere.
#if defined(__AVX2__)
#define PIPEWRIGHT_FAN_ISA avx2
#include "perception/map/fan_kernels_inl.h"
#endif
