// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdio>
#include <vector>

#include "perception/map/voxel_grid.h"
#include "perception/scene.h"
#include "plan/goal.h"
#include "platform/can/loopback_bus.h"
#include "platform/drivers/device_fault.h"
#include "tests/bench/robot_side.h"
#include "tests/timing/replay/byte_stream.h"

/// What entered and what left the control cycle, cycle by cycle, in a file that any machine reads:
///
///   "PWCYCLES", version
///   head      seed, LoopConfig, map's box and field, its voxels, the scene
///   cycle     'C', when, frames in, a goal when there is a new one, frames out      0 or more
///   end       'E', number of cycles, hash of all before
///
/// Numbers as ByteWriter puts them. There is no wall clock in it: one run gives one file.
namespace pipewright::timing {

/// A voxel as a DistanceField takes it.
enum class VoxelKind : std::uint8_t { kFree, kObstacle, kUnknownObstacle };

struct RecordingHead {
  std::uint64_t seed = 0;
  bench::LoopConfig loop;
  MapConfig map;                     ///< box, width, field and columns; the rest is as by default
  std::vector<std::uint8_t> voxels;  ///< VoxelKind of each, in the grid's order
  Scene scene;
};

/// The head's part that a map is.
void TakeMap(const VoxelGrid& grid, RecordingHead& head);
/// A grid whose DistanceField is that of the grid which was taken, distance by distance.
VoxelGrid MakeMap(const RecordingHead& head);

using ReceivedFrames = FixedVector<can::Frame, can::LoopbackBus::kRxCapacity>;

struct RecordedCycle {
  Time now{};
  bool counted = false;   ///< not of the start, nor of what was to be skipped
  bool has_goal = false;  ///< there is a new one
  Goal goal;
  ReceivedFrames base_in;
  ReceivedFrames arm_in;
  TxBatch base_out;
  TxBatch arm_out;
};

class RecordingWriter {
 public:
  /// Starts the file with the head.
  RecordingWriter(std::FILE* file, const RecordingHead& head);

  void Add(const RecordedCycle& cycle);
  /// The end; false: the file did not take everything.
  bool Finish();

 private:
  ByteWriter out_;
  std::uint32_t cycles_ = 0;
};

/// Reads and checks: whatever the file holds, what is given is within its limits.
class RecordingReader {
 public:
  explicit RecordingReader(std::FILE* file) : in_(file) {}

  /// First; false: see problem().
  bool ReadHead(RecordingHead& head);
  /// false: the end, or see problem().
  bool Next(RecordedCycle& cycle);

  const char* problem() const { return in_.problem(); }  ///< nullptr: none
  std::int64_t offset() const { return in_.offset(); }   ///< of the problem, bytes

 private:
  void ReadEnd();

  ByteReader in_;
  std::uint32_t cycles_ = 0;
  Time last_{};
};

}  // namespace pipewright::timing
