// SPDX-License-Identifier: MIT
// Where the camera is, by KDL from the robot's URDF. What a whole file holds is tested by
// mcap_points_by_spec.py.
#include "hil/cli/depth_to_ros.h"

#include <gtest/gtest.h>
#include <zstd.h>

#include <cmath>
#include <cstring>

#include "hil/plant/plant.h"
#include "hil/replay/depth_writer.h"
#include "platform/core/rng.h"
#include "tests/support/can_logs.h"
#include "tests/support/command.h"

namespace pipewright::hil {
namespace {

namespace fs = std::filesystem;
using test::DataFrame;

constexpr std::int64_t kMs = 1'000'000;

template <typename Number>
Number At(std::string_view bytes, std::size_t place) {
  Number number;
  std::memcpy(&number, bytes.substr(place, sizeof number).data(), sizeof number);
  return number;
}

struct Message {
  std::int64_t time_ns = 0;
  std::string bytes;
};

/// The messages of one MCAP channel, by mcap.dev/spec.
std::vector<Message> MessagesOf(const std::string& file, std::uint16_t channel) {
  const auto for_each = [](std::string_view records, const auto& visit) {
    for (std::size_t at = 0; at + 9 <= records.size();) {
      const auto length = At<std::uint64_t>(records, at + 1);
      visit(static_cast<std::uint8_t>(records[at]), records.substr(at + 9, length));
      at += 9 + length;
    }
  };
  std::vector<Message> messages;
  for_each(std::string_view(file).substr(8), [&](std::uint8_t op, std::string_view chunk) {
    if (op != 0x06) {
      return;
    }
    constexpr std::size_t kHead = 8 + 8 + 8 + 4 + 4 + 4 + 8;  // packing: "zstd"
    std::string plain(At<std::uint64_t>(chunk, 16), '\0');
    ASSERT_EQ(
        ZSTD_decompress(plain.data(), plain.size(), chunk.data() + kHead, chunk.size() - kHead),
        plain.size());
    for_each(plain, [&](std::uint8_t inner, std::string_view message) {
      if (inner == 0x05 && At<std::uint16_t>(message, 0) == channel) {
        messages.push_back({At<std::int64_t>(message, 6), std::string(message.substr(22))});
      }
    });
  });
  return messages;
}

/// By CiA 402: 6064h and 606Ch, here in 1e-6 rad and rad/s.
LogFrame Feedback(int joint, double position_rad, double velocity_radps, std::int64_t stamp_ns) {
  std::vector<int> payload;
  for (const double value : {position_rad, velocity_radps}) {
    const auto raw = static_cast<std::uint32_t>(std::lround(1e6 * value));
    for (int shift = 0; shift < 32; shift += 8) {
      payload.push_back(static_cast<int>(raw >> shift & 0xFF));
    }
  }
  return DataFrame(0x180 + static_cast<std::uint32_t>(joint), payload, stamp_ns);
}

class DepthToRosTest : public testing::Test {
 protected:
  /// Writes frames of those stamps, and what comes of them with that log.
  void Convert(const std::vector<std::int64_t>& stamps, const std::vector<LogFrame>& log) {
    const fs::path folder = test::TestFolder();
    DepthWriter writer;
    ASSERT_TRUE(writer.Open(folder / "depth.z16.zst"));
    const auto frame = std::make_unique<DepthFrame>();
    frame->camera = {4, 4, 5, 5, 2, 2, 0.1, 6};
    for (const std::int64_t stamp : stamps) {
      frame->stamp = Time(Duration(stamp));
      writer.Add(*frame, frame->stamp);
    }
    ASSERT_TRUE(writer.Close());
    DepthReader reader;
    ASSERT_EQ(reader.Open(folder / "depth.z16.zst"), "");
    McapWriter file;
    ASSERT_EQ(file.Open(folder / "a.mcap", "ros2"), "");
    RosTopics topics(file);
    const std::uint16_t tf = topics.Channel("/tf", kRosTransforms);
    DepthToRos to_ros(topics, reader, 1);
    for (const LogFrame& one : log) {
      to_ros.Take(one);
    }
    to_ros.End();
    figures_ = to_ros.figures();
    ASSERT_EQ(file.Close(), "");
    transforms_ = MessagesOf(test::ReadFile(folder / "a.mcap"), tf);
  }

  /// As the last 7 doubles of a transform have it.
  static Isometry3d PoseIn(const Message& message) {
    const std::size_t begin = message.bytes.size() - 7 * sizeof(double);
    std::array<double, 7> value{};
    for (std::size_t i = 0; i < value.size(); ++i) {
      value[i] = At<double>(message.bytes, begin + i * sizeof(double));
    }
    const Eigen::Quaterniond turn(value[6], value[3], value[4], value[5]);
    EXPECT_NEAR(turn.norm(), 1, 1e-12);
    Isometry3d pose(turn);
    pose.translation() << value[0], value[1], value[2];
    return pose;
  }

  DepthToRos::Figures figures_;
  std::vector<Message> transforms_;
};

TEST_F(DepthToRosTest, PlacesTheCameraWhereKdlHasItWhileTheJointsMove) {
  const Plant reference(TracerUf7Description(), {}, Vec<kPlantJoints>::Zero());
  Rng rng(21);
  std::vector<LogFrame> log;
  std::vector<std::int64_t> stamps;
  std::vector<Isometry3d> expected;
  for (int trial = 0; trial < 40; ++trial) {
    Vec<kPlantJoints> q;
    Vec<kPlantJoints> qdot;
    const std::int64_t begin_ns = 100 * kMs * (trial + 1);
    const std::int64_t exposed_ns = begin_ns + (10 + rng.Index(15)) * kMs;
    for (int i = 0; i < kPlantJoints; ++i) {
      const double margin = 0.1;  // the plant stops at its limits
      q(i) = rng.Uniform(reference.lower_rad()(i) + margin, reference.upper_rad()(i) - margin);
      qdot(i) = rng.Uniform(-1, 1);
      // Each joint is read at a time of its own.
      const std::int64_t read_ns = begin_ns + i * kMs;
      const double before_s = 1e-9 * static_cast<double>(exposed_ns - read_ns);
      log.push_back(Feedback(i + 1, q(i) - before_s * qdot(i), qdot(i), read_ns));
    }
    stamps.push_back(exposed_ns);
    expected.push_back(Plant(TracerUf7Description(), {}, q).X_WS());
  }
  log.push_back(DataFrame(0x211, {}, 5000 * kMs));
  Convert(stamps, log);
  ASSERT_EQ(transforms_.size(), stamps.size());
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    EXPECT_EQ(transforms_[i].time_ns, stamps[i]);
    // On the wire a joint has 1e-6 rad, and the arm less than 1 m.
    EXPECT_LT((PoseIn(transforms_[i]).matrix() - expected[i].matrix()).norm(), 7e-6) << i;
  }
  EXPECT_EQ(figures_.without_joints, 0U);
}

TEST_F(DepthToRosTest, SaysNothingOfACameraWhoseJointsAreNotKnown) {
  std::vector<LogFrame> log;
  for (int joint = 1; joint <= 6; ++joint) {
    log.push_back(Feedback(joint, 0, 0, 10 * kMs));
  }
  log.push_back(Feedback(7, 0, 0, 20 * kMs));
  log.push_back(DataFrame(0x211, {}, 200 * kMs));
  // One joint was never heard; all were, at last; one at most 30 ms ago; longer ago.
  Convert({15 * kMs, 20 * kMs, 40 * kMs, 40 * kMs + 1}, log);
  EXPECT_EQ(figures_.written, 4U);
  EXPECT_EQ(figures_.without_joints, 2U);
  ASSERT_EQ(transforms_.size(), 2U);
  EXPECT_EQ(transforms_[0].time_ns, 20 * kMs);
  EXPECT_EQ(transforms_[1].time_ns, 40 * kMs);
}

TEST_F(DepthToRosTest, BelievesOneArmAndNoOldReading) {
  std::vector<LogFrame> log;
  const auto add = [&log](int channel, double position_rad, std::int64_t stamp_ns) {
    for (int joint = 1; joint <= 7; ++joint) {
      log.push_back(Feedback(joint, position_rad, 0, stamp_ns));
      log.back().channel = static_cast<std::uint8_t>(channel);
    }
  };
  add(1, 0.5, 10 * kMs);
  add(0, 1.0, 11 * kMs);
  add(1, 0.2, 9 * kMs);  // comes late
  log.push_back(DataFrame(0x181, {1, 2}, 12 * kMs));
  log.back().channel = 1;
  log.push_back(DataFrame(0x211, {}, 20 * kMs));
  Convert({15 * kMs}, log);
  ASSERT_EQ(transforms_.size(), 1U);
  const Plant plant(TracerUf7Description(), {}, Vec<kPlantJoints>::Constant(0.5));
  EXPECT_LT((PoseIn(transforms_[0]).matrix() - plant.X_WS().matrix()).norm(), 1e-12);
}

TEST_F(DepthToRosTest, LeavesOutWhatIsNotOfTheLogsTime) {
  Convert({1 * kMs, 9 * kMs, 10 * kMs, 20 * kMs, 21 * kMs},
          {DataFrame(0x211, {}, 10 * kMs), DataFrame(0x211, {}, 20 * kMs)});
  EXPECT_EQ(figures_.written, 2U);
  EXPECT_EQ(figures_.outside, 3U);
  EXPECT_EQ(figures_.first_ns, 1 * kMs);
  EXPECT_EQ(figures_.last_ns, 21 * kMs);
  EXPECT_EQ(figures_.log_first_ns, 10 * kMs);
  EXPECT_EQ(figures_.log_last_ns, 20 * kMs);
  Convert({1 * kMs}, {});
  EXPECT_EQ(figures_.outside, 1U);
  EXPECT_FALSE(figures_.log_first_ns);
}

}  // namespace
}  // namespace pipewright::hil
