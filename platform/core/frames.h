// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

/// The frames, by letter. Names read as in Drake: p_WQ is the position of Q from W, expressed in W;
/// X_WB the pose of B in W; v_WQ the velocity of Q relative to W, expressed in W.
///
///   W  world = map = odometry frame; z up, z = 0 on the floor
///   B  base: on the floor, midway between the drive wheels; x forward, z up (ISO 8855)
///   A  arm base: the foot of the arm, fixed in B
///   L  a body's own frame: the base platform, arm link i (modified DH), or the tool
///   F  flange: the last arm link's frame
///   S  sensor: the camera's optical centre; z along the optical axis, x right, y down in the
///   image.
///      The task of the control law is p_WS and z_WS.
///   P  probe: the centre of the sphere within which the probe covers surfaces
namespace pipewright {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

template <int n>
using Vec = Eigen::Matrix<double, n, 1>;
template <int rows, int cols>
using Mat = Eigen::Matrix<double, rows, cols>;

}  // namespace pipewright
