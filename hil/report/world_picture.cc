// SPDX-License-Identifier: MIT
#include "hil/report/world_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace pipewright::hil {
namespace {

constexpr double kDrawingWidth = 4600;  ///< tenths of a unit
constexpr std::size_t kMaxVoxels = 5000;
constexpr int kFaces = 3;
constexpr const char* kStateClass[] = {"out", "got", "missed"};

using Index = std::array<int, 3>;
using Surface = std::map<Index, SurfaceState>;

struct Point2 {
  long x = 0;
  long y = 0;
};

/// Isometric projection, seen from above along (sign, sign, 1): x and y are turned by half a turn
/// or not, so that the frame stays right-handed. Steps along the axes are whole numbers, so voxels
/// meet without seams.
struct Projection {
  int sign = 1;
  double voxel_m = 0.05;
  long across = 0;  ///< drawing units of one voxel along x or y: sideways,
  long down = 0;    ///< and down
  long up = 0;      ///< of one voxel along z

  Point2 Of(double i, double j, double k) const {
    const double a = sign * i;
    const double b = sign * j;
    return {std::lround((b - a) * static_cast<double>(across)),
            std::lround((a + b) * static_cast<double>(down) - k * static_cast<double>(up))};
  }
  Point2 Of(const Vector3d& p_m) const {
    return Of(p_m.x() / voxel_m, p_m.y() / voxel_m, p_m.z() / voxel_m);
  }
};

Surface SurfaceOf(const WorldView& world, double& voxel_m) {
  Surface surface;
  for (const WorldView::Voxel& v : world.surface) {
    SurfaceState& state = surface.try_emplace(v.index, v.state).first->second;
    state = std::max(state, v.state);
  }
  const auto half = [](int i) { return i >= 0 ? i / 2 : (i - 1) / 2; };
  while (surface.size() > kMaxVoxels) {
    Surface coarse;
    for (const auto& [index, state] : surface) {
      const Index parent{half(index[0]), half(index[1]), half(index[2])};
      SurfaceState& worst = coarse.try_emplace(parent, state).first->second;
      worst = std::max(worst, state);
    }
    surface = std::move(coarse);
    voxel_m *= 2;
  }
  return surface;
}

/// The faces of one depth, one direction, one state; they do not overlap, so order is free.
using Faces = std::map<std::array<int, 3>, std::string>;  // (depth, face, state) -> path

std::string FaceShape(const Projection& p, int face) {
  const long a = p.across;
  const long d = p.down;
  const long u = p.up;
  switch (face) {
    case 0:  // across +x: along y, up
      return fmt::format("l{} {}v{}l{} {}z", a, d, -u, -a, -d);
    case 1:  // across +y: along x, up
      return fmt::format("l{} {}v{}l{} {}z", -a, d, -u, a, -d);
    default:  // on top: along x, y
      return fmt::format("l{} {}l{} {}l{} {}z", -a, d, a, d, a, -d);
  }
}

Faces VisibleFaces(const Surface& surface, const Projection& p) {
  const std::string shapes[kFaces] = {FaceShape(p, 0), FaceShape(p, 1), FaceShape(p, 2)};
  Faces faces;
  for (const auto& [index, state] : surface) {
    const auto [i, j, k] = index;
    const int s = p.sign;
    const Index beside[kFaces] = {{i + s, j, k}, {i, j + s, k}, {i, j, k + 1}};
    // The corner that is farthest from the viewer, and from there to where each face starts.
    const int fi = s > 0 ? i : i + 1;
    const int fj = s > 0 ? j : j + 1;
    const Point2 start[kFaces] = {p.Of(fi + s, fj, k), p.Of(fi, fj + s, k), p.Of(fi, fj, k + 1)};
    for (int face = 0; face < kFaces; ++face) {
      if (!surface.contains(beside[face])) {
        faces[{s * (i + j) + k, face, static_cast<int>(state)}] +=
            fmt::format("M{} {}{}", start[face].x, start[face].y, shapes[face]);
      }
    }
  }
  return faces;
}

std::string Polyline(const Projection& p, const std::vector<Vector3d>& points) {
  std::string path;
  Point2 last;
  for (const Vector3d& point : points) {
    const Point2 at = p.Of(point);
    path += path.empty() ? fmt::format("M{} {}", at.x, at.y)
                         : fmt::format("l{} {}", at.x - last.x, at.y - last.y);
    last = at;
  }
  return path;
}

std::vector<std::vector<Vector3d>> BoxEdges(const Vector3d& lo, const Vector3d& hi) {
  const auto at = [&](int x, int y, int z) {
    return Vector3d(x != 0 ? hi.x() : lo.x(), y != 0 ? hi.y() : lo.y(), z != 0 ? hi.z() : lo.z());
  };
  std::vector<std::vector<Vector3d>> edges;
  for (const int z : {0, 1}) {
    edges.push_back({at(0, 0, z), at(1, 0, z), at(1, 1, z), at(0, 1, z), at(0, 0, z)});
  }
  for (const int x : {0, 1}) {
    for (const int y : {0, 1}) {
      edges.push_back({at(x, y, 0), at(x, y, 1)});
    }
  }
  return edges;
}

void DrawAxisNames(std::string& svg, const Projection& p, const WorldView& world) {
  const Vector3d lo = world.min_m;
  const Vector3d hi = world.max_m;
  // On the floor's near edges, below the drawing.
  const double near_x = p.sign > 0 ? hi.x() : lo.x();
  const double near_y = p.sign > 0 ? hi.y() : lo.y();
  const Point2 x = p.Of({(lo.x() + hi.x()) / 2, near_y, lo.z()});
  const Point2 y = p.Of({near_x, (lo.y() + hi.y()) / 2, lo.z()});
  const auto name = [&](const Point2& at, long side, const char* text) {
    svg += fmt::format(R"(<text class="axis-name" x="{}" y="{}">{}</text>)", at.x + side,
                       at.y + 170, text);
  };
  name(x, 90, p.sign > 0 ? "← x" : "x →");
  name(y, -90, p.sign > 0 ? "y →" : "← y");
}

std::string Draw(const WorldView& world, const Surface& surface, const Projection& p) {
  std::string svg;
  const auto path = [&svg](const std::string& classes, const std::string& d) {
    if (!d.empty()) {
      svg += fmt::format(R"(<path class="{}" d="{}"/>)", classes, d);
    }
  };
  const auto lines = [&](const std::vector<std::vector<Vector3d>>& all) {
    std::string d;
    for (const std::vector<Vector3d>& line : all) {
      d += Polyline(p, line);
    }
    return d;
  };
  path("outline", lines(world.outlines));
  path("frame", lines(BoxEdges(world.min_m, world.max_m)));
  for (const auto& [key, d] : VisibleFaces(surface, p)) {
    path(fmt::format("face f{} {}", key[1], kStateClass[key[2]]), d);
  }
  path("hand", Polyline(p, world.hand_path));
  std::string dots;
  for (const Vector3d& goal : world.goals) {
    const Point2 at = p.Of(goal);
    dots += fmt::format("M{} {}h0", at.x, at.y);
  }
  path("goals", dots);
  DrawAxisNames(svg, p, world);
  return svg;
}

std::string Drawing(const WorldView& world, const Surface& surface, Projection p) {
  const Vector3d size = (world.max_m - world.min_m) / p.voxel_m;
  const double scale = kDrawingWidth / (0.866 * (size.x() + size.y()));
  p.across = std::max(1L, std::lround(0.866 * scale));
  p.down = std::max(1L, std::lround(0.5 * scale));
  p.up = std::max(1L, std::lround(scale));
  std::vector<std::vector<Vector3d>> shown = BoxEdges(world.min_m, world.max_m);
  shown.push_back(world.hand_path);
  shown.push_back(world.goals);
  const Vector3d beside = Vector3d::Constant(0.2 * (world.max_m - world.min_m).maxCoeff());
  for (const std::vector<Vector3d>& line : world.outlines) {
    for (const Vector3d& point : line) {  // of a hall around it, what is far may be cut off
      const bool near = (point.array() >= (world.min_m - beside).array()).all() &&
                        (point.array() <= (world.max_m + beside).array()).all();
      if (near) {
        shown.push_back({point});
      }
    }
  }
  Point2 lo = p.Of(world.min_m);
  Point2 hi = lo;
  for (const std::vector<Vector3d>& points : shown) {
    for (const Vector3d& point : points) {
      const Point2 at = p.Of(point);
      lo = {std::min(lo.x, at.x), std::min(lo.y, at.y)};
      hi = {std::max(hi.x, at.x), std::max(hi.y, at.y)};
    }
  }
  constexpr long kMargin = 260;
  return fmt::format(
      R"(<figure class="view"><figcaption>{}</figcaption>)"
      R"(<svg viewBox="{} {} {} {}" role="img" aria-label="{}">{}</svg></figure>)"
      "\n",
      p.sign > 0 ? "seen from +x, +y, above" : "seen from −x, −y, above", lo.x - kMargin,
      lo.y - kMargin, hi.x - lo.x + 2 * kMargin, hi.y - lo.y + 2 * kMargin,
      p.sign > 0 ? "surface, first view" : "surface, second view", Draw(world, surface, p));
}

}  // namespace

std::string RenderWorld(const WorldView& world) {
  if (!((world.max_m - world.min_m).array() > 0).all() || !(world.voxel_m > 0)) {
    return "";
  }
  double voxel_m = world.voxel_m;
  const Surface surface = SurfaceOf(world, voxel_m);
  return Drawing(world, surface, {.sign = -1, .voxel_m = voxel_m}) +
         Drawing(world, surface, {.sign = 1, .voxel_m = voxel_m});
}

}  // namespace pipewright::hil
