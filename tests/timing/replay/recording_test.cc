// SPDX-License-Identifier: MIT
#include "tests/timing/replay/recording.h"

#include <gtest/gtest.h>

#include <string>

#include "platform/core/rng.h"
#include "tests/timing/replay/temporary_file.h"

namespace pipewright::timing {
namespace {

/// A head as small as one can be, with something in every list.
RecordingHead SmallHead() {
  RecordingHead head;
  head.seed = 0x0123456789ABCDEF;
  head.loop = {.period_s = 0.004, .arm_cycle_ms = 8, .x_m = -0.5, .y_m = 1e-300, .phi_rad = 3};
  head.map.lo = {-2, -1, 0};
  head.map.hi = {0, 1, 1};
  head.voxels.assign(18, static_cast<std::uint8_t>(VoxelKind::kFree));
  head.voxels[7] = static_cast<std::uint8_t>(VoxelKind::kUnknownObstacle);
  PlaneEstimate plane;
  plane.id = 7;
  plane.covariance(3, 1) = -0.25;
  plane.extent_hi_m[1] = 2;
  PipeEstimate pipe;
  pipe.radius_m = 0.05;
  pipe.covariance(6, 2) = 1e-9;
  EXPECT_TRUE(head.scene.planes.push_back(plane));
  EXPECT_TRUE(head.scene.pipes.push_back(pipe));
  return head;
}

RecordedCycle SmallCycle(int i) {
  RecordedCycle cycle;
  cycle.now = Time{std::chrono::milliseconds(4 * i)};
  cycle.counted = i > 0;
  cycle.has_goal = i == 1;
  cycle.goal.id = 3;
  cycle.goal.p_WS = {1, -2, 0.5};
  EXPECT_TRUE(cycle.goal.path.push_back(Configuration::LinSpaced(-1, 1)));
  can::Frame frame{.id = 0x1ABCDEF0, .dlc = 3, .extended = true, .data = {1, 2, 255}};
  frame.stamp = cycle.now - std::chrono::nanoseconds(1);
  EXPECT_TRUE(cycle.base_in.push_back(frame));
  EXPECT_TRUE(cycle.arm_out.push_back({.id = 0x201, .dlc = 6, .data = {15, 0, 1}}));
  EXPECT_TRUE(cycle.arm_out.push_back({.id = 0x80}));
  return cycle;
}

std::string SmallRecording() {
  TemporaryFile file;
  RecordingWriter writer(file.get(), SmallHead());
  for (int i = 0; i < 3; ++i) {
    writer.Add(SmallCycle(i));
  }
  EXPECT_TRUE(writer.Finish());
  return file.Contents();
}

/// The problem of a recording that is read to its end; nullptr: none.
const char* ProblemOf(const std::string& bytes) {
  const TemporaryFile file(bytes);
  RecordingReader reader(file.get());
  RecordingHead head;
  RecordedCycle cycle;
  if (reader.ReadHead(head)) {
    while (reader.Next(cycle)) {
    }
  }
  return reader.problem();
}

TEST(Recording, BeginsWithItsNameAndTheVersionLowByteFirst) {
  const std::string bytes = SmallRecording();
  EXPECT_EQ(bytes.substr(0, 12), std::string("PWCYCLES\1\0\0\0", 12));
  EXPECT_EQ(bytes.substr(12, 8), "\xEF\xCD\xAB\x89\x67\x45\x23\x01");  // the seed
  EXPECT_EQ(bytes.substr(20, 8), "\xFC\xA9\xF1\xD2\x4D\x62\x70\x3F");  // 0.004, by IEEE 754
}

TEST(Recording, IsReadAsItWasWritten) {
  const TemporaryFile file(SmallRecording());
  RecordingReader reader(file.get());
  RecordingHead head;
  ASSERT_TRUE(reader.ReadHead(head)) << reader.problem();
  const RecordingHead wrote = SmallHead();
  EXPECT_EQ(head.seed, wrote.seed);
  EXPECT_EQ(head.loop.period_s, wrote.loop.period_s);
  EXPECT_EQ(head.loop.arm_cycle_ms, wrote.loop.arm_cycle_ms);
  EXPECT_EQ(head.loop.x_m, wrote.loop.x_m);
  EXPECT_EQ(head.loop.y_m, wrote.loop.y_m);
  EXPECT_EQ(head.loop.phi_rad, wrote.loop.phi_rad);
  EXPECT_EQ(head.map.lo, wrote.map.lo);
  EXPECT_EQ(head.map.hi, wrote.map.hi);
  EXPECT_EQ(head.voxels, wrote.voxels);
  ASSERT_EQ(head.scene.planes.size(), 1);
  EXPECT_EQ(head.scene.planes[0].id, 7U);
  EXPECT_EQ(head.scene.planes[0].covariance, wrote.scene.planes[0].covariance);
  EXPECT_EQ(head.scene.planes[0].extent_hi_m[1], 2);
  ASSERT_EQ(head.scene.pipes.size(), 1);
  EXPECT_EQ(head.scene.pipes[0].radius_m, 0.05);
  EXPECT_EQ(head.scene.pipes[0].covariance, wrote.scene.pipes[0].covariance);
  RecordedCycle cycle;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(reader.Next(cycle)) << reader.problem();
    const RecordedCycle in = SmallCycle(i);
    EXPECT_EQ(cycle.now, in.now);
    EXPECT_EQ(cycle.counted, in.counted);
    ASSERT_EQ(cycle.has_goal, in.has_goal);
    if (in.has_goal) {
      EXPECT_EQ(cycle.goal.id, in.goal.id);
      EXPECT_EQ(cycle.goal.p_WS, in.goal.p_WS);
      ASSERT_EQ(cycle.goal.path.size(), 1);
      EXPECT_EQ(cycle.goal.path[0], in.goal.path[0]);
    }
    ASSERT_EQ(cycle.base_in.size(), 1);
    EXPECT_EQ(cycle.base_in[0], in.base_in[0]);
    EXPECT_EQ(cycle.base_in[0].stamp, in.base_in[0].stamp);
    EXPECT_TRUE(cycle.arm_in.empty());
    EXPECT_TRUE(cycle.base_out.empty());
    ASSERT_EQ(cycle.arm_out.size(), 2);
    EXPECT_EQ(cycle.arm_out[0], in.arm_out[0]);
    EXPECT_EQ(cycle.arm_out[1], in.arm_out[1]);
  }
  EXPECT_FALSE(reader.Next(cycle));
  EXPECT_EQ(reader.problem(), nullptr);
}

TEST(Recording, IsRefusedWhereverItIsCut) {
  const std::string bytes = SmallRecording();
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_NE(ProblemOf(bytes.substr(0, n)), nullptr) << n;
  }
}

TEST(Recording, IsRefusedWhicheverByteIsChanged) {
  const std::string bytes = SmallRecording();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (const int change : {0x01, 0x80, 0xFF}) {
      std::string changed = bytes;
      changed[i] = static_cast<char>(changed[i] ^ change);
      EXPECT_NE(ProblemOf(changed), nullptr) << i << " by " << change;
    }
  }
}

TEST(Recording, SaysWhatIsWrong) {
  const std::string bytes = SmallRecording();
  const auto with = [&bytes](std::size_t at, const std::string& replacement) {
    return std::string(bytes).replace(at, replacement.size(), replacement);
  };
  EXPECT_STREQ(ProblemOf("a text"), "it ends early");
  EXPECT_STREQ(ProblemOf(with(0, "P")), nullptr);
  EXPECT_STREQ(ProblemOf(with(0, "p")), "it is no recording of control cycles");
  EXPECT_STREQ(ProblemOf(with(8, "\2")), "it is of another version");
  EXPECT_STREQ(ProblemOf(with(26, "\xF0\x7F")), "a number is not finite");  // the period
  EXPECT_STREQ(ProblemOf(with(28, "\x63")), "its rates are out of range");  // the arm's, 99 ms
  EXPECT_STREQ(ProblemOf(with(64, std::string("\1\0\0\0", 4))),
               "its map is out of range");  // lo.x > hi.x
  EXPECT_STREQ(ProblemOf(bytes.substr(0, bytes.size() - 1)), "it ends early");
}

/// What is written by hand can break what the writer never would, with the right hash.
TEST(Recording, RefusesTimeThatStandsStill) {
  TemporaryFile file;
  RecordingWriter writer(file.get(), SmallHead());
  writer.Add(SmallCycle(1));
  writer.Add(SmallCycle(1));
  ASSERT_TRUE(writer.Finish());
  EXPECT_STREQ(ProblemOf(file.Contents()), "time does not go on");
}

TEST(Recording, RefusesAFrameOfNineBytes) {
  TemporaryFile file;
  RecordingWriter writer(file.get(), SmallHead());
  RecordedCycle cycle = SmallCycle(0);
  cycle.base_in[0].dlc = 9;
  writer.Add(cycle);
  ASSERT_TRUE(writer.Finish());
  EXPECT_STREQ(ProblemOf(file.Contents()), "a frame has more than 8 bytes");
}

/// A map with voxels of every sort: seen free, hit, hit and then seen free, swept, never seen.
VoxelGrid MixedMap(Rng& rng) {
  MapConfig config;
  config.lo = {-10, -10, -4};
  config.hi = {29, 29, 25};
  config.workspace_lo = config.lo;
  config.workspace_hi = config.hi;
  config.brick_capacity = BricksOfBox(config);
  VoxelGrid grid(config);
  for (int scan = 0; scan < 4; ++scan) {
    const Vector3f origin{0.2F, 0.5F, 0.4F};
    for (int i = 0; i < 400; ++i) {
      const Vector3f point =
          Vector3d{rng.Uniform(0.3, 1.4), rng.Uniform(-0.4, 1.4), rng.Uniform(-0.1, 1.2)}
              .cast<float>();
      static_cast<void>(grid.InsertScan(&point, 1, origin, -1));
    }
  }
  grid.MarkSweptSphere({0, 0, 0.3}, 0.4);
  return grid;
}

TEST(RecordedMap, GivesTheSameDistances) {
  Rng rng(3);
  const VoxelGrid grid = MixedMap(rng);
  DistanceField field(grid.config());
  field.Update(grid);
  RecordingHead head;
  TakeMap(grid, head);
  DistanceField again(head.map);
  again.Update(MakeMap(head));
  int unknown = 0;
  int known = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3d p_W{rng.Uniform(-0.6, 1.6), rng.Uniform(-0.6, 1.6), rng.Uniform(-0.3, 1.4)};
    const Nearest was = field.NearestObstacle(p_W);
    const Nearest is = again.NearestObstacle(p_W);
    ASSERT_EQ(is.distance_m, was.distance_m);
    ASSERT_EQ(is.voxel, was.voxel);
    ASSERT_EQ(is.unknown, was.unknown);
    const Nearest was_column = field.NearestColumn(p_W.x(), p_W.y());
    const Nearest is_column = again.NearestColumn(p_W.x(), p_W.y());
    ASSERT_EQ(is_column.distance_m, was_column.distance_m);
    ASSERT_EQ(is_column.unknown, was_column.unknown);
    unknown += was.any && was.unknown ? 1 : 0;
    known += was.any && !was.unknown ? 1 : 0;
  }
  EXPECT_GT(unknown, 1000);  // the map has both kinds
  EXPECT_GT(known, 1000);
}

}  // namespace
}  // namespace pipewright::timing
