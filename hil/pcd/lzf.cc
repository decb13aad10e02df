// SPDX-License-Identifier: MIT
#include "hil/pcd/lzf.h"

#include <algorithm>

namespace pipewright::hil {

std::optional<std::size_t> UnpackLzf(std::span<const unsigned char> packed,
                                     std::span<unsigned char> out) {
  constexpr unsigned kLiteral = 32;
  constexpr unsigned kLong = 7;
  std::size_t at = 0;
  std::size_t to = 0;
  while (at < packed.size()) {
    const std::size_t start = at;
    const unsigned control = packed[at++];
    if (control < kLiteral) {
      const std::size_t length = control + 1;
      if (length > packed.size() - at || length > out.size() - to) {
        return start;
      }
      std::copy_n(packed.begin() + static_cast<std::ptrdiff_t>(at), length,
                  out.begin() + static_cast<std::ptrdiff_t>(to));
      at += length;
      to += length;
      continue;
    }
    std::size_t length = (control >> 5) + 2;
    const std::size_t more = (control >> 5) == kLong ? 2 : 1;
    if (more > packed.size() - at) {
      return start;
    }
    length += more == 2 ? packed[at++] : 0;
    const std::size_t back = ((control & 31U) << 8 | packed[at++]) + 1;
    if (back > to || length > out.size() - to) {
      return start;
    }
    for (std::size_t k = 0; k < length; ++k, ++to) {
      out[to] = out[to - back];
    }
  }
  return to == out.size() ? std::nullopt : std::optional<std::size_t>(packed.size());
}

}  // namespace pipewright::hil
