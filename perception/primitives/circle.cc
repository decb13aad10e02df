// SPDX-License-Identifier: MIT
#include "perception/primitives/circle.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace pipewright {

bool CircleAcross(const Vector3d& l_S, std::span<const Eigen::Vector3f> p_SQ, CylinderFit& pipe) {
  const Vector3d e1 = l_S.unitOrthogonal();
  const Vector3d e2 = l_S.cross(e1);
  const Vector3d origin = p_SQ[0].cast<double>();
  Matrix3d N = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  for (const Eigen::Vector3f& p : p_SQ) {
    const Vector3d w = p.cast<double>() - origin;
    const Vector3d row{e1.dot(w), e2.dot(w), 1};
    const double square = row.head<2>().squaredNorm();
    N += row * row.transpose();
    b -= square * row;
  }
  const Vector3d DEF = N.ldlt().solve(b);
  const double cx = -DEF.x() / 2;
  const double cy = -DEF.y() / 2;
  const double r2 = cx * cx + cy * cy - DEF.z();
  if (!DEF.allFinite() || !(r2 > 0)) {
    return false;
  }
  pipe.l_S = l_S;
  pipe.p_S = origin + cx * e1 + cy * e2;
  pipe.radius_m = std::sqrt(r2);
  return true;
}

}  // namespace pipewright
