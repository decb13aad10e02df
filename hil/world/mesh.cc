// SPDX-License-Identifier: MIT
#include "hil/world/mesh.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "hil/world/convex_distance.h"

namespace pipewright::hil {
namespace {

constexpr int kLeafTriangles = 4;
constexpr std::size_t kMaxTriangles = 2'000'000;

double BoxDistance(const Vector3d& lo, const Vector3d& hi, const Vector3d& p) {
  return (lo - p).cwiseMax(p - hi).cwiseMax(0).norm();
}

/// All triangles of a scene's meshes under one node, placed by the node's transforms.
void Collect(const aiScene& scene, const aiNode& node, const aiMatrix4x4& X_RootParent,
             std::vector<Vector3d>& vertices, std::vector<Mesh::Triangle>& triangles) {
  const aiMatrix4x4 X_RootNode = X_RootParent * node.mTransformation;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
    const int first = static_cast<int>(vertices.size());
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D p = X_RootNode * mesh.mVertices[i];
      vertices.emplace_back(p.x, p.y, p.z);
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices == 3) {
        triangles.push_back({first + static_cast<int>(face.mIndices[0]),
                             first + static_cast<int>(face.mIndices[1]),
                             first + static_cast<int>(face.mIndices[2])});
      }
    }
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    Collect(scene, *node.mChildren[i], X_RootNode, vertices, triangles);
  }
}

}  // namespace

Mesh::Mesh(std::vector<Vector3d> vertices_W, const std::vector<Triangle>& triangles)
    : vertices_(std::move(vertices_W)) {
  for (const Triangle& t : triangles) {
    const Vector3d& a = vertices_[t[0]];
    if ((vertices_[t[1]] - a).cross(vertices_[t[2]] - a).norm() > 0) {
      triangles_.push_back(t);
    }
  }
  closed_ = IsClosed();
  order_.resize(triangles_.size());
  std::iota(order_.begin(), order_.end(), 0);
  if (!order_.empty()) {
    nodes_.reserve(2 * order_.size());
    nodes_.emplace_back();
    Build(0, 0, static_cast<int>(order_.size()));
  }
}

bool Mesh::IsClosed() const {
  // Vertices are told apart by their place: formats as STL repeat them for every triangle.
  const auto before = [](const Vector3d& a, const Vector3d& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::map<Vector3d, int, decltype(before)> places(before);
  std::map<std::pair<int, int>, int> directed;
  for (const Triangle& t : triangles_) {
    int corner[3];
    for (int i = 0; i < 3; ++i) {
      corner[i] =
          places.try_emplace(vertices_[t[i]], static_cast<int>(places.size())).first->second;
    }
    for (int i = 0; i < 3; ++i) {
      ++directed[{corner[i], corner[(i + 1) % 3]}];
    }
  }
  for (const auto& [edge, count] : directed) {
    const auto opposite = directed.find({edge.second, edge.first});
    if (opposite == directed.end() || opposite->second != count) {
      return false;
    }
  }
  return !directed.empty();
}

void Mesh::Build(int node, int first, int count) {
  Vector3d lo = Vector3d::Constant(1e300);
  Vector3d hi = -lo;
  for (int i = first; i < first + count; ++i) {
    for (const int corner : triangles_[order_[i]]) {
      lo = lo.cwiseMin(vertices_[corner]);
      hi = hi.cwiseMax(vertices_[corner]);
    }
  }
  nodes_[node].lo = lo;
  nodes_[node].hi = hi;
  if (count <= kLeafTriangles) {
    nodes_[node].first = first;
    nodes_[node].count = count;
    return;
  }
  int axis = 0;
  (hi - lo).maxCoeff(&axis);
  const int half = count / 2;
  const auto middle = [&](int t) {
    return vertices_[triangles_[t][0]][axis] + vertices_[triangles_[t][1]][axis] +
           vertices_[triangles_[t][2]][axis];
  };
  std::nth_element(order_.begin() + first, order_.begin() + first + half,
                   order_.begin() + first + count,
                   [&](int s, int t) { return middle(s) < middle(t); });
  const int left = static_cast<int>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[node].first = left;
  Build(left, first, half);
  Build(left + 1, first + half, count - half);
}

double Mesh::Distance(const Shape& shape, const Isometry3d& X_WG, double stop_above_m) const {
  if (nodes_.empty()) {
    return stop_above_m;
  }
  const Vector3d center = X_WG.translation();
  if (closed_ && BoxDistance(lo_W(), hi_W(), center) == 0 && Inside(center)) {
    return 0;
  }
  const double radius = BoundingRadius(shape);
  const Isometry3d X_WW = Isometry3d::Identity();
  double best = stop_above_m;
  int stack[64];
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const Node& node = nodes_[stack[--depth]];
    if (BoxDistance(node.lo, node.hi, center) - radius > best) {
      continue;
    }
    if (node.count == 0) {
      stack[depth++] = node.first;
      stack[depth++] = node.first + 1;
      continue;
    }
    for (int i = node.first; i < node.first + node.count; ++i) {
      const Triangle& t = triangles_[order_[i]];
      const Shape face = Shape::Triangle(vertices_[t[0]], vertices_[t[1]], vertices_[t[2]]);
      best = std::min(best, ConvexDistance(face, X_WW, shape, X_WG, best));
    }
  }
  return best;
}

bool Mesh::Inside(const Vector3d& p_W) const {
  double angle = 0;
  for (const Triangle& t : triangles_) {
    const Vector3d a = vertices_[t[0]] - p_W;
    const Vector3d b = vertices_[t[1]] - p_W;
    const Vector3d c = vertices_[t[2]] - p_W;
    const double la = a.norm();
    const double lb = b.norm();
    const double lc = c.norm();
    angle += 2 * std::atan2(a.dot(b.cross(c)),
                            la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return std::abs(angle) > 2 * std::numbers::pi;
}

bool LoadMesh(const std::string& file, double scale, const Isometry3d& X_WG, Mesh& mesh,
              std::string& error) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file, aiProcess_Triangulate | aiProcess_SortByPType);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    error = importer.GetErrorString();
    return false;
  }
  std::vector<Vector3d> vertices;
  std::vector<Mesh::Triangle> triangles;
  Collect(*scene, *scene->mRootNode, aiMatrix4x4(), vertices, triangles);
  if (triangles.empty() || triangles.size() > kMaxTriangles) {
    error = triangles.empty() ? "holds no triangle" : "holds more than 2 000 000 triangles";
    return false;
  }
  for (Vector3d& p : vertices) {
    p = X_WG * (p * scale);
    if (!p.allFinite()) {
      error = "holds a vertex that is not finite";
      return false;
    }
  }
  mesh = Mesh(std::move(vertices), triangles);
  return true;
}

}  // namespace pipewright::hil
