// SPDX-License-Identifier: MIT
#include "hil/world/coverage.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace pipewright::hil {
namespace {

using Index = std::array<int, 3>;
using Sample = SurfaceVoxels::Sample;
using Binned = std::vector<std::pair<Index, Sample>>;

/// A pipe that ends on a wall shares a disc with it: samples this deep in another solid are hidden.
constexpr double kHidden_m = -1e-6;

Index VoxelOf(const Vector3d& p_W) {
  // A nanometre against coordinates that are meant to lie on a voxel face.
  const Eigen::Array3d cell = ((p_W.array() + 1e-9) / kVoxelWidth_m).floor();
  return {static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())};
}

class Sampler {
 public:
  Sampler(const Scenario& scenario, double spacing_m)
      : scenario_(scenario), range_(VoxelsOf(scenario.workspace)), spacing_m_(spacing_m) {
    center_W_ = (scenario.workspace.min_m + scenario.workspace.max_m) / 2;
    reach_m_ = (scenario.workspace.max_m - scenario.workspace.min_m).norm() / 2 + kVoxelWidth_m;
  }

  Binned Run() {
    for (own_ = 0; own_ < static_cast<int>(scenario_.solids.size()); ++own_) {
      const Solid& solid = scenario_.solids[own_];
      switch (solid.kind) {
        case SolidKind::kPlane:
          Plane(solid);
          break;
        case SolidKind::kBox:
          Box(solid);
          break;
        case SolidKind::kCylinder:
          Cylinder(solid);
          break;
        case SolidKind::kMesh:
          Faces(*solid.mesh);
          break;
      }
    }
    return std::move(binned_);
  }

 private:
  int Steps(double length_m) const {
    return std::max(1, static_cast<int>(std::ceil(length_m / spacing_m_)));
  }

  void Add(const Vector3d& p_W, const Vector3d& n_W) {
    const Index voxel = VoxelOf(p_W);
    for (int i = 0; i < 3; ++i) {
      if (voxel[i] < range_.lo[i] || voxel[i] > range_.hi[i]) {
        return;
      }
    }
    for (int i = 0; i < static_cast<int>(scenario_.solids.size()); ++i) {
      if (i != own_ && Hides(scenario_.solids[i], p_W)) {
        return;
      }
    }
    binned_.push_back({voxel, {p_W.cast<float>(), n_W.cast<float>()}});
  }

  static bool Hides(const Solid& solid, const Vector3d& p_W) {
    if (solid.kind == SolidKind::kMesh) {
      const bool near = ((p_W - solid.mesh->lo_W()).array() > 0).all() &&
                        ((solid.mesh->hi_W() - p_W).array() > 0).all();
      return near && solid.mesh->closed() && solid.mesh->Inside(p_W);
    }
    return Distance(solid, p_W) < kHidden_m;
  }

  /// Of n cells along the line through center_W with the half extent h: those that can be in W.
  std::pair<int, int> Clip(const Vector3d& center_W, const Vector3d& h, int n) const {
    const double middle = h.dot(center_W_ - center_W) / h.squaredNorm();
    const double slack = reach_m_ / h.norm();
    const auto cell = [&](double s) {
      return static_cast<int>(std::clamp((s + 1) / 2 * n, 0.0, static_cast<double>(n)));
    };
    return {cell(middle - slack), std::min(n, cell(middle + slack) + 1)};
  }

  /// A rectangle with centre and the two half edges, its normal along a x b, cells no wider than
  /// the spacing; only the part that can be in W.
  void Rectangle(const Vector3d& center_W, const Vector3d& a, const Vector3d& b) {
    const int na = Steps(2 * a.norm());
    const int nb = Steps(2 * b.norm());
    const Vector3d n_W = a.cross(b).normalized();
    if (std::abs(n_W.dot(center_W_ - center_W)) > reach_m_) {
      return;
    }
    const auto [a_first, a_last] = Clip(center_W, a, na);
    const auto [b_first, b_last] = Clip(center_W, b, nb);
    for (int i = a_first; i < a_last; ++i) {
      for (int j = b_first; j < b_last; ++j) {
        Add(center_W + a * ((2 * i + 1.0) / na - 1) + b * ((2 * j + 1.0) / nb - 1), n_W);
      }
    }
  }

  void Plane(const Solid& solid) {
    const Matrix3d R = solid.X_WG.linear();
    const double height_m = Distance(solid, center_W_);
    const Vector3d foot = center_W_ - R.col(2) * height_m;
    Rectangle(foot, R.col(0) * reach_m_, R.col(1) * reach_m_);
  }

  void Box(const Solid& solid) {
    const Vector3d half = solid.shape.size_m / 2;
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3;
      const int v = (axis + 2) % 3;
      for (const double side : {-1.0, 1.0}) {
        const Matrix3d R = solid.X_WG.linear();
        const Vector3d center = solid.X_WG.translation() + R.col(axis) * (side * half[axis]);
        Rectangle(center, R.col(u) * (side * half[u]), R.col(v) * half[v]);
      }
    }
  }

  void Cylinder(const Solid& solid) {
    const double radius_m = solid.shape.size_m.x();
    const double length_m = solid.shape.size_m.y();
    const int along = Steps(length_m);
    const int around = std::max(8, Steps(2 * std::numbers::pi * radius_m));
    const Vector3d half_W = solid.X_WG.linear().col(2) * (length_m / 2);
    const auto [first, last] = Clip(solid.X_WG.translation(), half_W, along);
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * std::numbers::pi * (k + 0.5) / around;
      const Vector3d n_G(std::cos(angle), std::sin(angle), 0);
      const Vector3d n_W = solid.X_WG.linear() * n_G;
      for (int i = first; i < last; ++i) {
        const Vector3d on_axis(0, 0, length_m * ((i + 0.5) / along - 0.5));
        Add(solid.X_WG * (on_axis + n_G * radius_m), n_W);
      }
    }
    for (const double side : {-1.0, 1.0}) {
      Disc(solid, side);
    }
  }

  void Disc(const Solid& solid, double side) {
    const double radius_m = solid.shape.size_m.x();
    const Vector3d n_W = solid.X_WG.linear().col(2) * side;
    const int rings = Steps(radius_m);
    for (int r = 0; r < rings; ++r) {
      const double rho = radius_m * (r + 0.5) / rings;
      const int around = std::max(3, Steps(2 * std::numbers::pi * rho));
      for (int k = 0; k < around; ++k) {
        const double angle = 2 * std::numbers::pi * k / around;
        Add(solid.X_WG * Vector3d(rho * std::cos(angle), rho * std::sin(angle),
                                  side * solid.shape.size_m.y() / 2),
            n_W);
      }
    }
  }

  void Faces(const Mesh& mesh) {
    for (const Mesh::Triangle& t : mesh.triangles()) {
      const Vector3d& a = mesh.vertices()[t[0]];
      const Vector3d& b = mesh.vertices()[t[1]];
      const Vector3d& c = mesh.vertices()[t[2]];
      const Vector3d n_W = mesh.closed() ? Vector3d((b - a).cross(c - a).normalized())  //
                                         : Vector3d::Zero();
      Face(a, b, c, n_W);
    }
  }

  /// Quarters a triangle until its edges are no longer than the spacing.
  void Face(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& n_W) {
    const Vector3d middle = (a + b + c) / 3;
    const double longest_m = std::max({(b - a).norm(), (c - a).norm(), (c - b).norm()});
    if ((middle - center_W_).norm() > reach_m_ + longest_m) {
      return;
    }
    if (longest_m <= spacing_m_) {
      Add(middle, n_W);
      return;
    }
    const Vector3d ab = (a + b) / 2;
    const Vector3d bc = (b + c) / 2;
    const Vector3d ca = (c + a) / 2;
    Face(a, ab, ca, n_W);
    Face(ab, b, bc, n_W);
    Face(ca, bc, c, n_W);
    Face(ab, bc, ca, n_W);
  }

  const Scenario& scenario_;
  VoxelRange range_;
  double spacing_m_;
  Vector3d center_W_;
  double reach_m_ = 0;
  int own_ = 0;
  Binned binned_;
};

}  // namespace

SurfaceVoxels SampleSurface(const Scenario& scenario, double spacing_m) {
  Binned binned = Sampler(scenario, spacing_m).Run();
  std::stable_sort(binned.begin(), binned.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  SurfaceVoxels surface;
  for (const auto& [index, sample] : binned) {
    if (surface.voxels.empty() || surface.voxels.back().index != index) {
      surface.voxels.push_back({index, static_cast<int>(surface.samples.size()), 0});
    }
    ++surface.voxels.back().count;
    surface.samples.push_back(sample);
  }
  return surface;
}

bool CoverageProbe::Covers(const Vector3d& p_WP, int voxel) const {
  const SurfaceVoxels::Voxel& v = surface_.voxels[voxel];
  const Vector3d center =
      (Vector3d(v.index[0], v.index[1], v.index[2]).array() + 0.5).matrix() * kVoxelWidth_m;
  const double reach_m = radius_m_ + kVoxelWidth_m * std::numbers::sqrt3 / 2;
  if ((center - p_WP).squaredNorm() > reach_m * reach_m) {
    return false;
  }
  for (int i = v.first; i < v.first + v.count; ++i) {
    const Sample& sample = surface_.samples[i];
    const Vector3d p_W = sample.p_W.cast<double>();
    const Vector3d to_P = p_WP - p_W;
    const bool two_sided = sample.n_W.squaredNorm() == 0;
    if (to_P.squaredNorm() <= radius_m_ * radius_m_ &&
        (two_sided || sample.n_W.cast<double>().dot(to_P) > 0) && !rays_.Occluded(p_WP, p_W)) {
      return true;
    }
  }
  return false;
}

int CoverageProbe::Add(const Vector3d& p_WP, std::vector<std::uint8_t>& covered) const {
  int added = 0;
  for (int i = 0; i < static_cast<int>(surface_.voxels.size()); ++i) {
    if (covered[i] == 0 && Covers(p_WP, i)) {
      covered[i] = 1;
      ++added;
    }
  }
  return added;
}

}  // namespace pipewright::hil
