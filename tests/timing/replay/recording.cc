// SPDX-License-Identifier: MIT
#include "tests/timing/replay/recording.h"

#include <cassert>

namespace pipewright::timing {
namespace {

constexpr std::uint64_t kMagic = 0x53454C4359435750U;  // "PWCYCLES", low byte first
constexpr std::uint32_t kVersion = 1;
constexpr std::uint8_t kCycleTag = 'C';
constexpr std::uint8_t kEndTag = 'E';
constexpr int kMostVoxels = 1 << 22;  // four bytes each in a field: what a small machine holds
constexpr std::int64_t kLatest_ns =
    1'000'000'000'000'000'000;      // times to 30 years: sums of them fit
constexpr float kSurelyFree = -10;  // log-odds; clamped by the grid
constexpr float kSurelyOccupied = 10;

// Each list of fields below serves both directions: what is written is what is read.

template <typename Stream, typename Matrix>
void PassMatrix(Stream& s, Matrix& m) {
  for (Eigen::Index i = 0; i < m.size(); ++i) {
    s.Pass(m.data()[i]);
  }
}

template <typename Stream, typename T>
void PassTime(Stream& s, T& time) {
  std::int64_t ns = time.time_since_epoch().count();
  s.Pass(ns);
  if constexpr (Stream::kReads) {
    if (ns < -kLatest_ns || ns > kLatest_ns) {
      s.Fail("a time is out of range");
      ns = 0;
    }
    time = Time{Duration{ns}};
  }
}

/// Up to the vector's capacity; each by `pass`.
template <typename Stream, typename Items, typename PassOne>
void PassItems(Stream& s, Items& items, const PassOne& pass) {
  auto n = static_cast<std::uint16_t>(items.size());
  s.Pass(n);
  if constexpr (Stream::kReads) {
    items.clear();
    for (int i = 0; s.ok() && i < n; ++i) {
      std::remove_cvref_t<decltype(items[0])> item{};
      pass(item);
      if (!items.push_back(item)) {
        s.Fail("there are more of a kind than there can be");
      }
    }
  } else {
    for (const auto& item : items) {
      pass(item);
    }
  }
}

template <typename Stream, typename T>
void PassLoop(Stream& s, T& loop) {
  s.Pass(loop.period_s);
  s.Pass(loop.arm_cycle_ms);
  s.Pass(loop.x_m);
  s.Pass(loop.y_m);
  s.Pass(loop.phi_rad);
  s.Pass(loop.reached);
}

template <typename Stream, typename T>
void PassMap(Stream& s, T& map) {
  for (auto* v : {&map.lo, &map.hi}) {
    s.Pass(v->x);
    s.Pass(v->y);
    s.Pass(v->z);
  }
  s.Pass(map.width_m);
  s.Pass(map.field_range_m);
  s.Pass(map.column_lo_m);
  s.Pass(map.column_hi_m);
  s.Pass(map.outside_is_obstacle);
}

template <typename Stream, typename T>
void PassPlane(Stream& s, T& plane) {
  s.Pass(plane.id);
  PassMatrix(s, plane.n_W);
  s.Pass(plane.d_m);
  PassMatrix(s, plane.covariance);
  PassMatrix(s, plane.p_WCentroid);
  PassMatrix(s, plane.e1_W);
  PassMatrix(s, plane.e2_W);
  for (const int i : {0, 1}) {
    s.Pass(plane.extent_lo_m[i]);
    s.Pass(plane.extent_hi_m[i]);
  }
  s.Pass(plane.frames_seen);
  PassTime(s, plane.last_seen);
}

template <typename Stream, typename T>
void PassPipe(Stream& s, T& pipe) {
  s.Pass(pipe.id);
  PassMatrix(s, pipe.p_W);
  PassMatrix(s, pipe.l_W);
  s.Pass(pipe.radius_m);
  PassMatrix(s, pipe.covariance);
  s.Pass(pipe.extent_lo_m);
  s.Pass(pipe.extent_hi_m);
  s.Pass(pipe.frames_seen);
  PassTime(s, pipe.last_seen);
}

template <typename Stream, typename T>
void PassScene(Stream& s, T& scene) {
  PassTime(s, scene.stamp);
  PassItems(s, scene.planes, [&s](auto& plane) { PassPlane(s, plane); });
  PassItems(s, scene.pipes, [&s](auto& pipe) { PassPipe(s, pipe); });
}

template <typename Stream, typename T>
void PassFrame(Stream& s, T& frame) {
  s.Pass(frame.id);
  s.Pass(frame.dlc);
  s.Pass(frame.extended);
  s.Pass(frame.remote);
  s.Pass(frame.error);
  for (auto& byte : frame.data) {
    s.Pass(byte);
  }
  PassTime(s, frame.stamp);
  if constexpr (Stream::kReads) {
    if (frame.dlc > 8) {
      s.Fail("a frame has more than 8 bytes");
      frame.dlc = 0;
    }
  }
}

template <typename Stream, typename T>
void PassGoal(Stream& s, T& goal) {
  s.Pass(goal.id);
  PassMatrix(s, goal.p_WS);
  PassMatrix(s, goal.z_WS);
  PassItems(s, goal.path, [&s](auto& q) { PassMatrix(s, q); });
}

template <typename Stream, typename T>
void PassCycle(Stream& s, T& cycle) {
  const auto frame = [&s](auto& f) { PassFrame(s, f); };
  PassTime(s, cycle.now);
  s.Pass(cycle.counted);
  PassItems(s, cycle.base_in, frame);
  PassItems(s, cycle.arm_in, frame);
  s.Pass(cycle.has_goal);
  if (cycle.has_goal) {
    PassGoal(s, cycle.goal);
  }
  PassItems(s, cycle.base_out, frame);
  PassItems(s, cycle.arm_out, frame);
}

bool Valid(const bench::LoopConfig& loop) {
  return 0.001 <= loop.period_s && loop.period_s <= 0.02 && 1 <= loop.arm_cycle_ms &&
         loop.arm_cycle_ms <= 20 && loop.reached > 0;
}

/// Within the box, and small enough. The grid's own check comes first: it bounds the product.
bool Fits(const MapConfig& map) {
  return pipewright::Valid(map) && VoxelsAlong(map.lo.x, map.hi.x) *
                                           VoxelsAlong(map.lo.y, map.hi.y) *
                                           VoxelsAlong(map.lo.z, map.hi.z) <=
                                       kMostVoxels;
}

}  // namespace

void TakeMap(const VoxelGrid& grid, RecordingHead& head) {
  head.map = grid.config();
  head.voxels.resize(static_cast<std::size_t>(grid.voxel_count()));
  for (int i = 0; i < grid.voxel_count(); ++i) {
    const VoxelKind kind = !grid.ObstacleAt(i) ? VoxelKind::kFree
                           : grid.KnownAt(i)   ? VoxelKind::kObstacle
                                               : VoxelKind::kUnknownObstacle;
    head.voxels[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(kind);
  }
}

VoxelGrid MakeMap(const RecordingHead& head) {
  VoxelGrid grid(head.map);
  for (int i = 0; i < grid.voxel_count(); ++i) {
    const auto kind = static_cast<VoxelKind>(head.voxels[static_cast<std::size_t>(i)]);
    if (kind != VoxelKind::kUnknownObstacle) {
      const bool free = kind == VoxelKind::kFree;
      const bool taken = grid.Restore(grid.VoxelAt(i), free ? kSurelyFree : kSurelyOccupied);
      assert(taken);
      static_cast<void>(taken);
    }
  }
  return grid;
}

RecordingWriter::RecordingWriter(std::FILE* file, const RecordingHead& head) : out_(file) {
  out_.Pass(kMagic);
  out_.Pass(kVersion);
  out_.Pass(head.seed);
  PassLoop(out_, head.loop);
  PassMap(out_, head.map);
  for (const std::uint8_t voxel : head.voxels) {
    out_.Pass(voxel);
  }
  PassScene(out_, head.scene);
}

void RecordingWriter::Add(const RecordedCycle& cycle) {
  out_.Pass(kCycleTag);
  PassCycle(out_, cycle);
  ++cycles_;
}

bool RecordingWriter::Finish() {
  out_.Pass(kEndTag);
  out_.Pass(cycles_);
  const std::uint64_t hash = out_.hash();
  out_.Pass(hash);
  return out_.ok();
}

bool RecordingReader::ReadHead(RecordingHead& head) {
  std::uint64_t magic = 0;
  std::uint32_t version = 0;
  in_.Pass(magic);
  if (magic != kMagic) {
    in_.Fail("it is no recording of control cycles");
  }
  in_.Pass(version);
  if (version != kVersion) {
    in_.Fail("it is of another version");
  }
  in_.Pass(head.seed);
  PassLoop(in_, head.loop);
  if (!Valid(head.loop)) {
    in_.Fail("its rates are out of range");
  }
  PassMap(in_, head.map);
  head.map.workspace_lo = head.map.lo;
  head.map.workspace_hi = head.map.hi;
  if (!in_.ok() || !Fits(head.map)) {
    in_.Fail("its map is out of range");
    return false;
  }
  head.map.brick_capacity = BricksOfBox(head.map);
  const int voxels = VoxelsAlong(head.map.lo.x, head.map.hi.x) *
                     VoxelsAlong(head.map.lo.y, head.map.hi.y) *
                     VoxelsAlong(head.map.lo.z, head.map.hi.z);
  head.voxels.resize(static_cast<std::size_t>(voxels));
  for (std::uint8_t& voxel : head.voxels) {
    in_.Pass(voxel);
    if (voxel > static_cast<std::uint8_t>(VoxelKind::kUnknownObstacle)) {
      in_.Fail("a voxel is of no kind");
    }
  }
  PassScene(in_, head.scene);
  return in_.ok();
}

bool RecordingReader::Next(RecordedCycle& cycle) {
  std::uint8_t tag = 0;
  in_.Pass(tag);
  if (tag == kEndTag) {
    ReadEnd();
    return false;
  }
  if (tag != kCycleTag) {
    in_.Fail("neither a cycle nor the end follows");
    return false;
  }
  PassCycle(in_, cycle);
  if (cycles_ > 0 && cycle.now <= last_) {
    in_.Fail("time does not go on");
  }
  last_ = cycle.now;
  ++cycles_;
  return in_.ok();
}

void RecordingReader::ReadEnd() {
  std::uint32_t cycles = 0;
  std::uint64_t written = 0;
  in_.Pass(cycles);
  const std::uint64_t hash = in_.hash();
  in_.Pass(written);
  if (cycles != cycles_ || written != hash) {
    in_.Fail("it was changed after it was written");
  }
}

}  // namespace pipewright::timing
