// SPDX-License-Identifier: MIT
#include "perception/primitives/depth_view.h"

#include <algorithm>
#include <cmath>

namespace pipewright {
namespace {

constexpr float kStep_m = 0.03F;  // neighbours farther apart in depth are two surfaces
constexpr int kMinNeighbours = 5;
constexpr int kWideImage = 160;  // pixels a row, from which normals take 5x5 rather than 3x3
constexpr float kMinZ_m = 0.05F;

}  // namespace

Status DepthView::Set(const Cloud& cloud, const DepthNoise& noise) {
  width_ = height_ = 0;
  c_1pm_ = static_cast<float>(noise.c_1pm);
  if (cloud.width < 4 || cloud.height < 4 || cloud.size() > Cloud::kMaxPoints ||
      !cloud.X_WS.matrix().allFinite()) {
    return Status::kMalformed;
  }
  int step = 1;
  while ((cloud.width / step) * (cloud.height / step) > kMaxPixels) {
    ++step;
  }
  width_ = cloud.width / step;
  height_ = cloud.height / step;
  X_WS_ = cloud.X_WS;
  for (int row = 0; row < height_; ++row) {
    for (int column = 0; column < width_; ++column) {
      const int i = row * width_ + column;
      const int source = row * step * cloud.width + column * step;
      const Eigen::Vector3f& p = cloud.p_SQ[source];
      const bool usable = cloud.valid[source] != 0 && p.allFinite() && p.z() > kMinZ_m;
      use_[i] = usable ? Use::kFree : Use::kNone;
      inverse_z_[i] = usable ? 1 / p.z() : 0;
      x_[i] = usable ? p.x() * inverse_z_[i] : 0;
      y_[i] = usable ? p.y() * inverse_z_[i] : 0;
      inverse_sigma_[i] = usable ? static_cast<float>(1 / noise.SigmaInverse(inverse_z_[i])) : 0;
    }
  }
  // What fills up the last four is not seen.
  std::fill_n(inverse_z_.begin() + size(), kLanes, 0.0F);
  std::fill_n(x_.begin() + size(), kLanes, 0.0F);
  std::fill_n(y_.begin() + size(), kLanes, 0.0F);
  std::fill_n(inverse_sigma_.begin() + size(), kLanes, 0.0F);
  std::fill_n(use_.begin() + size(), kLanes, Use::kNone);
  // The focal length, from two rays of the widest row.
  focal_ = 0;
  for (int row = 0; row < height_; ++row) {
    int first = row * width_;
    int last = first + width_ - 1;
    const int begin = first;
    while (first < last && !seen(first)) {
      ++first;
    }
    while (last > begin && !seen(last)) {
      --last;
    }
    const float span = first < last ? x_[last] - x_[first] : 0;
    if (span > 0 && last - first >= 4) {
      focal_ = std::max(focal_, static_cast<float>(last - first) / span);
    }
  }
  return focal_ > 0 ? Status::kOk : Status::kMalformed;
}

/// Least squares of w − w0 = a + b (x − x0) + g (y − y0) over a window about each of some pixels:
/// T holds one number of each.
template <typename T>
struct DepthView::NormalSums {
  T x0, y0, w0;
  T tolerance;
  T n{}, sx{}, sy{}, sw{}, sxx{}, syy{}, sxy{}, sxw{}, syw{};

  NormalSums(const T& x, const T& y, const T& w, float c_1pm)
      : x0(x), y0(y), w0(w), tolerance(kStep_m * w * w + 4 * c_1pm) {}

  /// Adds a neighbour's reading where it lies on the pixel's surface.
  [[gnu::always_inline]] void Add(const T& x, const T& y, const T& w) {
    const T none{};
    const auto on = (w > none) & (w - w0 <= tolerance) & (w0 - w <= tolerance);
    const T dx = on ? x - x0 : none;
    const T dy = on ? y - y0 : none;
    const T dw = on ? w - w0 : none;
    n += on ? none + 1 : none;
    sx += dx, sy += dy, sw += dw;
    sxx += dx * dx, syy += dy * dy, sxy += dx * dy;
    sxw += dx * dw, syw += dy * dw;
  }

  /// A normal of any length, zero where there are too few readings.
  void Solve(T& nx, T& ny, T& nz) const {
    const T vxx = sxx - sx * sx / n;
    const T vyy = syy - sy * sy / n;
    const T vxy = sxy - sx * sy / n;
    const T vxw = sxw - sx * sw / n;
    const T vyw = syw - sy * sw / n;
    const T determinant = vxx * vyy - vxy * vxy;
    const T b = (vxw * vyy - vyw * vxy) / determinant;
    const T g = (vyw * vxx - vxw * vxy) / determinant;
    const T a = w0 + (sw - b * sx - g * sy) / n;
    const T none{};
    const auto enough = (n >= none + kMinNeighbours) & (determinant > 0.05F * vxx * vyy);
    nx = enough ? -b : none;
    ny = enough ? -g : none;
    nz = enough ? b * x0 + g * y0 - a : none;
  }
};

namespace {

Eigen::Vector3f Unit(const Eigen::Vector3f& n) {
  const float length = std::sqrt(n.squaredNorm());
  return length > 1e-6F ? Eigen::Vector3f(n / length) : Eigen::Vector3f::Zero();
}

}  // namespace

Eigen::Vector3f DepthView::Normal(int i, int half) const {
  const int column = i % width_;
  const int row = i / width_;
  NormalSums<float> sums(x_[i], y_[i], inverse_z_[i], c_1pm_);
  for (int r = std::max(0, row - half); r <= std::min(height_ - 1, row + half); ++r) {
    for (int c = std::max(0, column - half); c <= std::min(width_ - 1, column + half); ++c) {
      const int j = r * width_ + c;
      sums.Add(x_[j], y_[j], inverse_z_[j]);
    }
  }
  Eigen::Vector3f n_S;
  sums.Solve(n_S.x(), n_S.y(), n_S.z());
  return Unit(n_S);
}

/// Of four pixels side by side, whose windows lie within the image's columns.
void DepthView::FourNormals(int i, int half, Eigen::Vector3f* n_S) const {
  const int row = i / width_;
  NormalSums<Floats> sums(Load(&x_[i]), Load(&y_[i]), Load(&inverse_z_[i]), c_1pm_);
  for (int r = std::max(0, row - half); r <= std::min(height_ - 1, row + half); ++r) {
    const int at = i + (r - row) * width_;
    for (int j = at - half; j <= at + half; ++j) {
      sums.Add(Load(&x_[j]), Load(&y_[j]), Load(&inverse_z_[j]));
    }
  }
  Floats nx, ny, nz;
  sums.Solve(nx, ny, nz);
  for (int lane = 0; lane < kLanes; ++lane) {
    n_S[lane] = Unit({nx[lane], ny[lane], nz[lane]});
  }
}

void DepthView::Normals(int begin, int end, Eigen::Vector3f* n_S) const {
  const int half = width_ >= kWideImage ? 2 : 1;
  const int row_begin = begin / width_ * width_;
  for (int i = begin; i < end;) {
    const int column = i - row_begin;
    const bool four = i + kLanes <= end && column >= half && column + kLanes + half <= width_;
    if (four) {
      FourNormals(i, half, n_S + (i - begin));
    } else {
      n_S[i - begin] = Normal(i, half);
    }
    i += four ? kLanes : 1;
  }
}

}  // namespace pipewright
