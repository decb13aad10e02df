// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "platform/core/depth_frame.h"
#include "platform/core/status.h"

namespace pipewright::hil {

/// A depth frame on a stream of bytes, low byte first:
///
///   byte  0  "PWZ1"
///         4  u32  sequence
///         8  i64  stamp, ns of CLOCK_MONOTONIC at the middle of the exposure
///        16  u32  width
///        20  u32  height
///        24  f64  fx fy cx cy [px], z_min z_max [m]
///        72  u16  depth along z_S in mm, 0 no reading; row by row, width times height
inline constexpr std::size_t kDepthHeadBytes = 72;

/// Replaces what `bytes` holds.
void PutDepthFrame(const DepthFrame& frame, std::vector<std::uint8_t>& bytes);

/// All but the pixels of `frame`. kMalformed: not the head of a frame, or one larger than
/// DepthFrame::kMaxPixels, or without a sound camera; `frame` is then as it was.
Status TakeDepthHead(std::span<const std::uint8_t, kDepthHeadBytes> bytes, DepthFrame& frame);

/// Of a frame whose head is in it.
std::size_t PixelBytes(const DepthFrame& frame);

/// @param bytes  PixelBytes(frame) of them
void TakePixels(std::span<const std::uint8_t> bytes, DepthFrame& frame);

}  // namespace pipewright::hil
