// SPDX-License-Identifier: MIT
#include "perception/cloud/cloud.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace pipewright {
namespace {

/// A 20x10 image of a wall at 1 m.
std::unique_ptr<DepthFrame> Wall() {
  auto frame = std::make_unique<DepthFrame>();
  frame->camera = {.width = 20,
                   .height = 10,
                   .fx = 10,
                   .fy = 12,
                   .cx = 9.5,
                   .cy = 4.5,
                   .z_min_m = 0.3,
                   .z_max_m = 3.0};
  for (int i = 0; i < 200; ++i) {
    frame->depth_mm[i] = 1000;
  }
  return frame;
}

struct Made {
  Status status;
  std::unique_ptr<Cloud> cloud = std::make_unique<Cloud>();
  CloudCounts counts;
};

Made Make(const DepthFrame& frame, std::span<const SelfBox> body = {},
          const CloudConfig& config = {}, const Isometry3d& X_WS = Isometry3d::Identity()) {
  Made made;
  made.status = MakeCloud(frame, X_WS, body, config, *made.cloud, made.counts);
  return made;
}

TEST(MakeCloud, ProjectsEveryPixelOfAWallBackToItself) {
  const auto frame = Wall();
  const Made made = Make(*frame);
  ASSERT_EQ(made.status, Status::kOk);
  EXPECT_EQ(made.cloud->valid_count, 200);
  for (int v = 0; v < 10; ++v) {
    for (int u = 0; u < 20; ++u) {
      const Eigen::Vector3f p = made.cloud->p_SQ[v * 20 + u];
      EXPECT_NEAR(p.x() / p.z() * 10 + 9.5, u, 1e-5);
      EXPECT_NEAR(p.y() / p.z() * 12 + 4.5, v, 1e-5);
      EXPECT_FLOAT_EQ(p.z(), 1.0F);
    }
  }
}

TEST(MakeCloud, DropsReadingsOutsideTheCamerasRangeAndCountsThem) {
  const auto frame = Wall();
  frame->depth_mm[0] = 0;
  for (int i = 20; i < 40; ++i) {
    frame->depth_mm[i] = 299;
  }
  for (int i = 180; i < 200; ++i) {
    frame->depth_mm[i] = 3001;
  }
  const Made made = Make(*frame);
  EXPECT_EQ(made.counts.no_reading, 1);
  EXPECT_EQ(made.counts.below_minimum_range, 20);
  EXPECT_EQ(made.counts.beyond_maximum_range, 20);
}

TEST(MakeCloud, DropsALoneReadingInFrontOfAWall) {
  const auto frame = Wall();
  frame->depth_mm[5 * 20 + 10] = 500;
  const Made made = Make(*frame);
  EXPECT_EQ(made.counts.speckle, 1);
  EXPECT_FALSE(made.cloud->valid[5 * 20 + 10]);
}

TEST(MakeCloud, DropsWhatTheCameraSeesOfTheRobotWhereverTheCameraIs) {
  const auto frame = Wall();
  Isometry3d X_WS = Isometry3d::Identity();
  X_WS.rotate(Eigen::AngleAxisd(1.2, Vector3d{1, 2, 3}.normalized()));
  X_WS.pretranslate(Vector3d{0.3, -2, 1});
  Isometry3d X_SG = Isometry3d::Identity();
  X_SG.translate(Vector3d{0.1, 0, 1});
  X_SG.rotate(Eigen::AngleAxisd(0.5, Vector3d::UnitZ()));
  const SelfBox box{X_WS * X_SG, Vector3d{0.3, 0.1, 0.05}};
  const Made made = Make(*frame, {&box, 1}, {}, X_WS);
  int inside = 0;
  for (int i = 0; i < 200; ++i) {
    const Vector3d p_S{(i % 20 - 9.5) / 10, (i / 20 - 4.5) / 12, 1};
    const Vector3d p_G = X_SG.inverse() * p_S;
    const double margin_m = CloudConfig{}.self_margin_m;
    inside += std::abs(p_G.x()) <= 0.3 + margin_m && std::abs(p_G.y()) <= 0.1 + margin_m;
  }
  EXPECT_GT(inside, 0);
  EXPECT_EQ(made.counts.self, inside);
  EXPECT_EQ(made.cloud->valid_count, 200 - inside);
}

TEST(MakeCloud, KeepsEveryStridethPixel) {
  const auto frame = Wall();
  const Made made = Make(*frame, {}, {.stride = 2});
  EXPECT_EQ(made.cloud->width, 10);
  EXPECT_EQ(made.cloud->height, 5);
  EXPECT_EQ(made.cloud->valid_count, 50);
}

TEST(MakeCloud, RefusesFramesThatMakeNoSense) {
  for (const auto& spoil :
       {+[](DepthFrame& f) { f.camera.width = 0; },
        +[](DepthFrame& f) { f.camera.height = 1 << 30; }, +[](DepthFrame& f) { f.camera.fx = 0; },
        +[](DepthFrame& f) { f.camera.fy = std::nan(""); },
        +[](DepthFrame& f) { f.camera.z_max_m = 0; }}) {
    const auto frame = Wall();
    spoil(*frame);
    const Made made = Make(*frame);
    EXPECT_EQ(made.status, Status::kMalformed);
    EXPECT_EQ(made.cloud->size(), 0);
  }
}

TEST(MakeCloud, SaysWhenTheImageExceedsItsCapacity) {
  const auto frame = Wall();
  frame->camera.width = 848;
  frame->camera.height = 480;
  EXPECT_EQ(Make(*frame).status, Status::kFull);
  EXPECT_EQ(Make(*frame, {}, {.stride = 2}).status, Status::kOk);
}

}  // namespace
}  // namespace pipewright
