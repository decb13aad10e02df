// SPDX-License-Identifier: MIT
// What is planned must be what the controller lets through: plan may not include ctrl, so the
// planner's distances are numbers of its own.
#include <gtest/gtest.h>

#include "ctrl/constraints/config.h"
#include "ctrl/constraints/svfi.h"
#include "plan/motion/collision.h"

namespace pipewright {
namespace {

TEST(Margins, ThePlannerKeepsWhatTheControllerKeepsAndSomeSlack) {
  const CollisionConfig planned;
  const ConstraintConfig kept;
  EXPECT_GT(planned.slack_m, 0);
  EXPECT_GE(planned.plane_m, kept.d_safe_plane_m);
  EXPECT_GE(planned.pipe_m, kept.d_safe_pipe_m);
  EXPECT_GE(planned.base_plane_m, kept.d_safe_base_plane_m);
  EXPECT_GE(planned.primitive_margin_m, kept.margin_m);
  // Standing still before an obstacle voxel at the α of Table I.
  const double voxel_buffer_m = *ChanceQuantile(kept.alpha) * kept.voxel_noise_m;
  EXPECT_GE(planned.voxel_margin_m, kept.voxel_margin_m + voxel_buffer_m);
  EXPECT_GE(planned.self_m, kept.self_margin_m);
  // Where a plane or a pipe counts at all.
  EXPECT_EQ(planned.upright_nz, kept.near_vertical_nz);
  EXPECT_EQ(planned.plane_border_m, kept.plane_inflation_m);
  EXPECT_EQ(planned.plane_behind_m, kept.plane_behind_m);
  EXPECT_EQ(planned.pipe_border_m, kept.pipe_inflation_m);
}

}  // namespace
}  // namespace pipewright
