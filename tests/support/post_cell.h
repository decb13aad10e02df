// SPDX-License-Identifier: MIT
#pragma once

namespace pipewright::test {

/// The smallest world worth a run: a post on a floor, in front of the robot.
inline constexpr const char* kPostCell = R"(
name = "cell"
[workspace]
min_m = [0.6, -0.3, 0.2]
max_m = [1.2, 0.3, 0.8]
[start]
x_m = 0.0
y_m = 0.0
yaw_rad = 0.0
[map]
lo_m = [-1.0, -1.0, -0.1]
hi_m = [1.7, 1.0, 1.3]
[[plane]]
name = "floor"
normal = [0, 0, 1]
offset_m = 0.0
ground = true
[[cylinder]]
name = "post"
from_m = [1.0, 0.0, 0.0]
to_m = [1.0, 0.0, 1.2]
radius_m = 0.06
)";

}  // namespace pipewright::test
