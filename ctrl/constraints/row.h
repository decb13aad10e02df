// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>

#include "platform/core/fixed_vector.h"
#include "platform/robot/robot.h"

namespace pipewright {

/// What a row keeps apart, or keeps within. Softness is configured per kind.
enum class RowKind : std::uint8_t {
  kPlane,          ///< robot point and plane
  kBasePlane,      ///< base centre and near-vertical plane
  kPipe,           ///< robot point and pipe axis
  kVoxel,          ///< robot point and the nearest obstacle voxel
  kColumn,         ///< base disc and the nearest obstacle column
  kSelf,           ///< two parts of the robot
  kJointVelocity,  ///< operating speed limit of a joint
  kRecovery,       ///< leave a place that turned out to be too near
};
inline constexpr int kRowKinds = 8;

/// One linear inequality on the controls u = [v, omega, q1' ... q7'].
///
///   lo ≤ a'u ≤ hi,  violated by s at a cost of price s²; price 0: never violated
struct Row {
  Controls a = Controls::Zero();
  double lo = -std::numeric_limits<double>::infinity();
  double hi = std::numeric_limits<double>::infinity();
  double price = 0;
  int key = 0;  ///< the same from cycle to cycle for the same pair: the QP's warm start
};

/// key = kind, then two numbers that identify the pair.
constexpr int RowKey(RowKind kind, int first, std::uint32_t second) {
  return (static_cast<int>(kind) << 26) | ((first & 0x3FF) << 16) |
         static_cast<int>(second & 0xFFFF);
}
constexpr RowKind KindOf(const Row& row) { return static_cast<RowKind>(row.key >> 26); }

/// Rows of the QP: deterministic ones (of the robot itself, and to leave places) and one cut for
/// each chance row (of the world).
inline constexpr int kMaxRows = 192;
inline constexpr int kMaxChanceRows = 128;
inline constexpr int kMaxPlainRows = kMaxRows - kMaxChanceRows;

using RowSet = FixedVector<Row, kMaxPlainRows>;

}  // namespace pipewright
