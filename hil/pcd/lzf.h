// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace pipewright::hil {

/// Unpacks LZF, the packing of binary_compressed PCD files. A control byte c, then
///
///   c < 32    c + 1 bytes as they are
///   else      a copy of what came before: length (c >> 5) + 2, where 7 means that the next byte is
///             added; from ((c & 31) << 8 | next byte) + 1 bytes back; it may overlap itself
///
/// @returns the byte of `packed` at which it stops making sense (its size when `out` is not
/// filled),
///          or nothing when `out` is exactly filled by all of it.
std::optional<std::size_t> UnpackLzf(std::span<const unsigned char> packed,
                                     std::span<unsigned char> out);

/// The most bytes that one packed byte can stand for, rounded up.
inline constexpr std::size_t kLzfLargestGrowth = 88;  // 264 from 3

}  // namespace pipewright::hil
