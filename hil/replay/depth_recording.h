// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

/// A recording of depth frames: with a CAN log, all that a robot program saw. Unpacked (`zstd -dc`)
/// it is a sequence of items, little-endian, without gaps:
///
///   'PWZ1'  u32 width, height; f64 fx, fy, cx, cy [px], z_min, z_max [m]     the camera from here
///   on 'PWZF'  u32 sequence; i64 given, stamp [ns]; u8 low[n], high[n], n = width height        a
///   frame 'PWZE'  u32 frames                                        the end, and how many frames
///   there are
///
/// `stamp` is the middle of the exposure, `given` the instant at which the program got the frame.
/// Depths are Z16 as the device sends them, bit for bit: 256 high[i] + low[i] = Fold(d[i] -
/// d[i-1]), row by row, d[-1] = 0. So most of `high` is 0 and a frame packs to 0.4 of its bytes,
/// where plain Z16 would to 0.7: what is left is noise.
///
/// Each item is a zstd frame of its own with a checksum: a file that breaks off, or is damaged, is
/// good up to the last whole item.
namespace pipewright::hil {

inline constexpr const char* kDepthFileName = "depth.z16.zst";  ///< in a run's folder

inline constexpr std::uint32_t kDepthCamera = 0x315A5750;  ///< "PWZ1"
inline constexpr std::uint32_t kDepthFrame = 0x465A5750;   ///< "PWZF"
inline constexpr std::uint32_t kDepthEnd = 0x455A5750;     ///< "PWZE"

/// A difference of 16 bits, small ones of either sign as small numbers: 0, -1, 1, -2, ... as 0, 1,
/// 2, 3, ... Unfold is its inverse.
constexpr std::uint16_t Fold(std::uint16_t difference) {
  const std::uint16_t sign = (difference & 0x8000U) != 0 ? 0xFFFF : 0;
  return static_cast<std::uint16_t>(difference << 1 ^ sign);
}
constexpr std::uint16_t Unfold(std::uint16_t folded) {
  const std::uint16_t sign = (folded & 1U) != 0 ? 0xFFFF : 0;
  return static_cast<std::uint16_t>(folded >> 1 ^ sign);
}

}  // namespace pipewright::hil
