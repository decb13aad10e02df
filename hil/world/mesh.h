// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string>
#include <vector>

#include "hil/world/shape.h"

namespace pipewright::hil {

/// Triangles in W [m], with a tree of boxes over them for distances.
class Mesh {
 public:
  using Triangle = std::array<int, 3>;

  Mesh() = default;
  /// Triangles whose indices are in range and whose area is not zero.
  Mesh(std::vector<Vector3d> vertices_W, const std::vector<Triangle>& triangles);

  const std::vector<Vector3d>& vertices() const { return vertices_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }

  /// Whether every edge belongs to two triangles that run through it in opposite directions. Only
  /// then has the mesh an inside, and its normals point out.
  bool closed() const { return closed_; }

  Vector3d lo_W() const { return nodes_.empty() ? Vector3d::Zero() : nodes_[0].lo; }
  Vector3d hi_W() const { return nodes_.empty() ? Vector3d::Zero() : nodes_[0].hi; }

  /// Distance of a convex shape to the nearest triangle [m], 0 on touch; also 0 when the mesh is
  /// closed and the shape's origin lies inside. Search ends above stop_above_m, as in
  /// ConvexDistance.
  double Distance(const Shape& shape, const Isometry3d& X_WG, double stop_above_m) const;

  /// Whether a point lies inside a closed mesh: the sum of the solid angles of all triangles (Van
  /// Oosterom, Strackee: The solid angle of a plane triangle, 1983) is 4 pi. Linear in the
  /// triangles.
  bool Inside(const Vector3d& p_W) const;

 private:
  struct Node {
    Vector3d lo, hi;
    int first = 0;  ///< leaf: first of order_; else: the left child, the right one follows
    int count = 0;  ///< 0: inner node
  };

  void Build(int node, int first, int count);
  bool IsClosed() const;

  std::vector<Vector3d> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
  bool closed_ = false;
};

/// Reads a file that Assimp knows (STL, OBJ, PLY, Collada, ...), scales it and places it in W.
/// On failure returns false and says why.
bool LoadMesh(const std::string& file, double scale, const Isometry3d& X_WG, Mesh& mesh,
              std::string& error);

}  // namespace pipewright::hil
